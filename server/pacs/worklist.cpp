// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/worklist.hpp"

#include "server/pacs/association.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "proto/base/printable.hpp"
#include "proto/dicom/dataset_fields.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostEntries = 500;
constexpr int kAnswerSeconds = 60;

struct Keys {
  DcmTagKey key;
  std::string DicomIdentity::*member;
};

const std::vector<Keys>& identity_keys() {
  static const std::vector<Keys> keys = {
      {DCM_PatientName, &DicomIdentity::patient_name},
      {DCM_PatientID, &DicomIdentity::patient_id},
      {DCM_IssuerOfPatientID, &DicomIdentity::issuer_of_patient_id},
      {DCM_PatientBirthDate, &DicomIdentity::birth_date},
      {DCM_PatientSex, &DicomIdentity::sex},
      {DCM_AccessionNumber, &DicomIdentity::accession_number},
      {DCM_StudyInstanceUID, &DicomIdentity::study_uid},
      {DCM_ReferringPhysicianName, &DicomIdentity::referring_physician},
      {DCM_RequestedProcedureID, &DicomIdentity::requested_procedure_id},
      {DCM_RequestedProcedureDescription, &DicomIdentity::study_description},
  };
  return keys;
}

void add_keys(DicomFields& fields, const WorklistQuery& query) {
  fields.text(DCM_SpecificCharacterSet, "ISO_IR 192");
  for (const auto& [key, member] : identity_keys()) {
    if (key == DCM_PatientID) {
      fields.text(key, query.patient_id);
    } else if (key == DCM_AccessionNumber) {
      fields.text(key, query.accession_number);
    } else {
      fields.empty(key);
    }
  }
  DicomFields step = fields.item(DCM_ScheduledProcedureStepSequence);
  step.text(DCM_Modality, query.modality);
  step.text(DCM_ScheduledStationAETitle, query.station_title);
  step.text(DCM_ScheduledProcedureStepStartDate, query.date);
  for (const DcmTagKey& key : {DCM_ScheduledProcedureStepStartTime, DCM_ScheduledProcedureStepDescription,
                               DCM_ScheduledProcedureStepID})
    step.empty(key);
}

WorklistEntry entry_of(DcmDataset& dataset) {
  WorklistEntry entry;
  entry.has_unknown_characters = dataset.convertToUTF8().bad();
  for (const auto& [key, member] : identity_keys()) entry.identity.*member = dicom_text(dataset, key);
  DcmItem* step = nullptr;
  if (dataset.findAndGetSequenceItem(DCM_ScheduledProcedureStepSequence, step).bad() || step == nullptr)
    return entry;
  entry.identity.scheduled_step_id = dicom_text(*step, DCM_ScheduledProcedureStepID);
  entry.date = dicom_text(*step, DCM_ScheduledProcedureStepStartDate);
  entry.time = dicom_text(*step, DCM_ScheduledProcedureStepStartTime);
  entry.step_description = dicom_text(*step, DCM_ScheduledProcedureStepDescription);
  entry.station_title = dicom_text(*step, DCM_ScheduledStationAETitle);
  return entry;
}

/// What has come of an answer.
struct Answer {
  std::vector<WorklistEntry> entries;
  bool too_many = false;
  std::uint16_t failure = 0;  ///< status; 0: none

  /// Whether more responses are wanted.
  bool take(QRResponse& response) {
    const bool pending = DICOM_PENDING_STATUS(response.m_status);
    if (!pending && response.m_status != STATUS_Success) failure = response.m_status;
    if (!pending || response.m_dataset == nullptr) return true;
    too_many = entries.size() == kMostEntries;
    if (!too_many) entries.push_back(entry_of(*response.m_dataset));
    return !too_many;
  }
};

}  // namespace

Result<std::vector<WorklistEntry>> find_worklist(const DicomPeer& peer, const WorklistQuery& query) {
  const std::string model = UID_FINDModalityWorklistInformationModel;
  auto association = Association::open(
      peer, {{model, {UID_LittleEndianExplicitTransferSyntax, UID_LittleEndianImplicitTransferSyntax}}},
      kAnswerSeconds);
  if (!association) return association.error();
  DicomScu& scu = association->scu();
  const auto failed = [&](std::string_view problem) {
    return Error{ErrorCode::kBadInput, fmt::format("{}: {}, expected a worklist", shown(peer), problem)};
  };
  DcmDataset keys;
  bool incomplete = false;
  DicomFields fields(keys, incomplete);
  add_keys(fields, query);
  if (incomplete) return failed("the query cannot be made");
  Answer answer;
  scu.take_response = [&answer](QRResponse& response) { return answer.take(response); };
  const auto id = scu.findAnyPresentationContextID(model.c_str(), UID_LittleEndianExplicitTransferSyntax);
  const OFCondition found = scu.sendFINDRequest(id, &keys, nullptr);
  if (answer.too_many)
    return failed(fmt::format("it has more than {} entries, expected a narrower query", kMostEntries));
  if (found.bad()) return failed(fmt::format("no answer to the query ({})", printable(found.text())));
  if (answer.failure != 0) return failed(fmt::format("it reports a failure, status {:#06x}", answer.failure));
  std::ranges::stable_sort(answer.entries, {}, [](const WorklistEntry& entry) {
    return std::pair{entry.date, entry.time};
  });
  return std::move(answer.entries);
}

}  // namespace fanlight
