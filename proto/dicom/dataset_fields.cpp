// SPDX-License-Identifier: Apache-2.0
#include "proto/dicom/dataset_fields.hpp"

#include <dcmtk/dcmdata/dcuid.h>

namespace fanlight {

std::string dicom_text(DcmItem& item, const DcmTagKey& key) {
  OFString value;
  if (item.findAndGetOFStringArray(key, value).bad()) return "";
  std::string text(value.c_str());
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

std::string new_dicom_uid(const char* root) {
  std::array<char, 128> uid{};
  return dcmGenerateUniqueIdentifier(uid.data(), root);
}

void add_identity(DicomFields& fields, const DicomIdentity& identity) {
  fields.text(DCM_SpecificCharacterSet, "ISO_IR 192");  // UTF-8
  fields.text(DCM_PatientName, identity.patient_name);
  fields.text(DCM_PatientID, identity.patient_id);
  fields.optional_text(DCM_IssuerOfPatientID, identity.issuer_of_patient_id);
  fields.text(DCM_PatientBirthDate, identity.birth_date);
  fields.text(DCM_PatientSex, identity.sex);
  fields.text(DCM_AccessionNumber, identity.accession_number);
  fields.text(DCM_ReferringPhysicianName, identity.referring_physician);
  fields.text(DCM_StudyID, identity.study_id);
  fields.optional_text(DCM_StudyDescription, identity.study_description);
  fields.text(DCM_StudyInstanceUID,
              identity.study_uid.empty() ? new_dicom_uid(SITE_STUDY_UID_ROOT) : identity.study_uid);
  if (identity.requested_procedure_id.empty() && identity.scheduled_step_id.empty()) return;
  DicomFields request = fields.item(DCM_RequestAttributesSequence);
  request.optional_text(DCM_RequestedProcedureID, identity.requested_procedure_id);
  request.optional_text(DCM_ScheduledProcedureStepID, identity.scheduled_step_id);
}

void silence_dicom_log() {
  static const bool silent = [] {
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    return true;
  }();
  (void)silent;
}

}  // namespace fanlight
