// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/store.hpp"

#include "server/pacs/association.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "proto/base/printable.hpp"
#include "server/pacs/dicom_file.hpp"

namespace fanlight {

namespace {

using State = StoreOutcome::State;

constexpr std::string_view kNotAccepted = "it does not accept objects of this kind, or not in this encoding";

/// A file's object, as its head describes it.
struct ObjectHead {
  DicomContext context;
  StoreOutcome problem;  ///< kNotTried where there is none
};

ObjectHead refused(const std::filesystem::path& path, std::string_view problem) {
  return {.context = {},
          .problem = {State::kRefused, fmt::format("{} {}", printable(path.string()), problem)}};
}

bool is_uncompressed(const std::string& syntax) {
  return syntax == UID_LittleEndianExplicitTransferSyntax || syntax == UID_LittleEndianImplicitTransferSyntax;
}

ObjectHead head_of(const std::filesystem::path& path) {
  const auto is_dicom = is_dicom_file(path);
  if (!is_dicom) return {.context = {}, .problem = {State::kNotSent, is_dicom.error().message}};
  DcmMetaInfo head;
  std::string sop_class;
  std::string syntax;
  OFString value;
  const bool loaded = *is_dicom && head.loadFile(path.c_str()).good();
  if (loaded && head.findAndGetOFString(DCM_MediaStorageSOPClassUID, value).good()) sop_class = value.c_str();
  if (loaded && head.findAndGetOFString(DCM_TransferSyntaxUID, value).good()) syntax = value.c_str();
  if (sop_class.empty() || syntax.empty())
    return refused(path, "is not DICOM, expected a file with its meta information");
  if (!is_uncompressed(syntax)) return {.context = {sop_class, {syntax}}, .problem = {}};
  return {.context = {sop_class,
                      {UID_LittleEndianExplicitTransferSyntax, UID_LittleEndianImplicitTransferSyntax}},
          .problem = {}};
}

/// The presentation context that the peer has accepted for the object; 0: none.
T_ASC_PresentationContextID accepted(DicomScu& scu, const DicomContext& context) {
  for (const std::string& syntax : context.second) {
    const auto id = scu.findPresentationContextID(context.first.c_str(), syntax.c_str());
    if (id != 0) return id;
  }
  return 0;
}

/// What would fail before a byte is sent is found here, so that any later failure is one of the connection.
StoreOutcome store_file(DicomScu& scu, const std::filesystem::path& path, const DicomContext& context) {
  const auto id = accepted(scu, context);
  if (id == 0) return {State::kRefused, std::string(kNotAccepted)};
  DcmFileFormat file;
  if (const OFCondition read = file.loadFile(path.c_str()); read.bad())
    return refused(path, fmt::format("cannot be read ({}), expected DICOM", printable(read.text()))).problem;
  DcmDataset& object = *file.getDataset();
  OFString value;
  if (object.findAndGetOFString(DCM_SOPInstanceUID, value).bad() || value.empty())
    return refused(path, "has no SOP Instance UID, expected one").problem;
  if (object.findAndGetOFString(DCM_SOPClassUID, value).bad() || value.c_str() != context.first)
    return refused(path, "has another SOP class than its head, expected the same").problem;
  Uint16 status = 0;
  const OFCondition sent = scu.sendSTORERequest(id, "", &object, status);
  if (sent.good()) return outcome_of_status(status);
  (void)scu.abortAssociation();
  return {State::kNotSent, fmt::format("the connection broke ({})", printable(sent.text()))};
}

}  // namespace

StoreOutcome outcome_of_status(std::uint16_t status) {
  const auto is_one_of = [status](std::initializer_list<unsigned> statuses) {
    return std::ranges::find(statuses, unsigned{status}) != statuses.end();
  };
  constexpr unsigned kWarnings = 0xB000;      // to 0xBFFF
  constexpr unsigned kNoRoom = 0xA700;        // to 0xA7FF
  constexpr unsigned kHasItAlready = 0x0111;  // stored, and the answer to that was lost
  if (status == 0) return {State::kStored, ""};
  if (status == kHasItAlready) return {State::kStored, "it had the object already"};
  if ((status & 0xF000U) == kWarnings || is_one_of({0x0001, 0x0107, 0x0116}))
    return {State::kStored, fmt::format("stored with a warning, status {:#06x}", status)};
  if ((status & 0xFF00U) == kNoRoom)
    return {State::kNotSent, fmt::format("it has no room, status {:#06x}", status)};
  // Processing failure, not authorized, resource limitation.
  if (is_one_of({0x0110, 0x0124, 0x0213}))
    return {State::kNotSent, fmt::format("it cannot store now, status {:#06x}", status)};
  return {State::kRefused, fmt::format("it refuses the object, status {:#06x}", status)};
}

Result<std::vector<StoreOutcome>> store_files(const DicomPeer& peer,
                                              std::span<const std::filesystem::path> files,
                                              const std::atomic<bool>& stop) {
  std::vector<ObjectHead> heads;
  std::vector<DicomContext> contexts;
  for (const std::filesystem::path& path : files) {
    heads.push_back(head_of(path));
    const ObjectHead& head = heads.back();
    const bool can_be_sent = head.problem.state == State::kNotTried;
    if (can_be_sent && std::ranges::find(contexts, head.context) == contexts.end())
      contexts.push_back(head.context);
  }
  std::vector<StoreOutcome> outcomes;
  if (contexts.empty()) {
    for (ObjectHead& head : heads) outcomes.push_back(std::move(head.problem));
    return outcomes;
  }
  auto association = Association::open(peer, contexts);
  if (!association && association.error().code != ErrorCode::kUnsupported) return association.error();
  for (std::size_t at = 0; at < files.size(); ++at) {
    ObjectHead& head = heads[at];
    if (head.problem.state != State::kNotTried) {
      outcomes.push_back(std::move(head.problem));
    } else if (!association) {
      outcomes.push_back({State::kRefused, std::string(kNotAccepted)});
    } else if (association->scu().isConnected() && !stop) {
      outcomes.push_back(store_file(association->scu(), files[at], head.context));
    } else {
      outcomes.emplace_back();
    }
  }
  return outcomes;
}

Result<void> check_echo(const DicomPeer& peer) {
  auto association =
      Association::open(peer, {{UID_VerificationSOPClass, {UID_LittleEndianImplicitTransferSyntax}}});
  if (!association) return association.error();
  const OFCondition answered = association->scu().sendECHORequest(0);
  if (answered.good()) return {};
  return Error{ErrorCode::kUnavailable, fmt::format("{}: no answer to an echo ({}), expected one",
                                                    shown(peer), printable(answered.text()))};
}

}  // namespace fanlight
