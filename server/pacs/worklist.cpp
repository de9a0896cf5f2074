// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/worklist.hpp"

#include "server/pacs/association.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "proto/base/printable.hpp"
#include "proto/dicom/dataset_fields.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostEntries = 500;

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

/// A text of the peer's; empty where it has none, or one that could deceive on a screen.
std::string text_of(DcmItem& item, const DcmTagKey& key) {
  OFString value;
  if (item.findAndGetOFStringArray(key, value).bad()) return "";
  std::string text(value.c_str());
  while (text.ends_with(' ')) text.pop_back();
  return printable(text);
}

WorklistEntry entry_of(DcmDataset& dataset) {
  (void)dataset.convertToUTF8();
  WorklistEntry entry;
  for (const auto& [key, member] : identity_keys()) entry.identity.*member = text_of(dataset, key);
  DcmItem* step = nullptr;
  if (dataset.findAndGetSequenceItem(DCM_ScheduledProcedureStepSequence, step).bad() || step == nullptr)
    return entry;
  entry.identity.scheduled_step_id = text_of(*step, DCM_ScheduledProcedureStepID);
  entry.date = text_of(*step, DCM_ScheduledProcedureStepStartDate);
  entry.time = text_of(*step, DCM_ScheduledProcedureStepStartTime);
  entry.step_description = text_of(*step, DCM_ScheduledProcedureStepDescription);
  entry.station_title = text_of(*step, DCM_ScheduledStationAETitle);
  return entry;
}

/// The responses, which DCMTK leaves to its caller.
struct Responses {
  OFList<QRResponse*> list;

  Responses() = default;
  Responses(const Responses&) = delete;
  Responses& operator=(const Responses&) = delete;
  ~Responses() {
    for (QRResponse* response : list) delete response;  // NOLINT(cppcoreguidelines-owning-memory)
  }
};

}  // namespace

Result<std::vector<WorklistEntry>> find_worklist(const DicomPeer& peer, const WorklistQuery& query) {
  const std::string model = UID_FINDModalityWorklistInformationModel;
  auto association = Association::open(
      peer, {{model, {UID_LittleEndianExplicitTransferSyntax, UID_LittleEndianImplicitTransferSyntax}}});
  if (!association) return association.error();
  DcmSCU& scu = association->scu();
  const auto failed = [&](std::string_view problem) {
    return Error{ErrorCode::kBadInput, fmt::format("{}: {}, expected a worklist", shown(peer), problem)};
  };
  DcmDataset keys;
  bool incomplete = false;
  DicomFields fields(keys, incomplete);
  add_keys(fields, query);
  if (incomplete) return failed("the query cannot be made");
  Responses responses;
  const auto id = scu.findAnyPresentationContextID(model.c_str(), UID_LittleEndianExplicitTransferSyntax);
  if (const OFCondition found = scu.sendFINDRequest(id, &keys, &responses.list); found.bad())
    return failed(fmt::format("no answer to the query ({})", printable(found.text())));
  std::vector<WorklistEntry> entries;
  for (QRResponse* response : responses.list) {
    const bool pending = DICOM_PENDING_STATUS(response->m_status);
    if (!pending && response->m_status != STATUS_Success)
      return failed(fmt::format("it reports a failure, status {:#06x}", response->m_status));
    if (!pending || response->m_dataset == nullptr) continue;
    if (entries.size() == kMostEntries)
      return failed(fmt::format("it has more than {} entries, expected a narrower query", kMostEntries));
    entries.push_back(entry_of(*response->m_dataset));
  }
  std::ranges::stable_sort(entries, {}, [](const WorklistEntry& entry) {
    return std::pair{entry.date, entry.time};
  });
  return entries;
}

}  // namespace fanlight
