// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/store.hpp"

#include "server/pacs/association.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

/// Statuses of a C-STORE response (PS3.4, table B.2-1).
constexpr Uint16 kNoRoom = 0xA700;    // to 0xA7FF
constexpr Uint16 kWarnings = 0xB000;  // to 0xBFFF: stored, with changes
constexpr Uint16 kNotAuthorized = 0x0124;
constexpr Uint16 kProcessingFailure = 0x0110;

constexpr std::string_view kNotAccepted = "it does not accept objects of this kind, or not in this encoding";

bool is_uncompressed(const std::string& syntax) {
  return syntax == UID_LittleEndianExplicitTransferSyntax || syntax == UID_LittleEndianImplicitTransferSyntax;
}

/// The contexts in which the file's object can be sent.
Result<DicomContext> context_of(const std::filesystem::path& path) {
  DcmMetaInfo head;
  std::string sop_class;
  std::string syntax;
  OFString value;
  const OFCondition loaded = head.loadFile(path.c_str());
  if (loaded.good() && head.findAndGetOFString(DCM_MediaStorageSOPClassUID, value).good())
    sop_class = value.c_str();
  if (loaded.good() && head.findAndGetOFString(DCM_TransferSyntaxUID, value).good()) syntax = value.c_str();
  if (sop_class.empty() || syntax.empty()) {
    return Error{
        ErrorCode::kBadInput,
        fmt::format("{} is not DICOM, expected a file with its meta information", printable(path.string()))};
  }
  if (is_uncompressed(syntax))
    return DicomContext{sop_class,
                        {UID_LittleEndianExplicitTransferSyntax, UID_LittleEndianImplicitTransferSyntax}};
  return DicomContext{sop_class, {syntax}};
}

StoreOutcome outcome_of(Uint16 status) {
  using State = StoreOutcome::State;
  if (status == STATUS_Success) return {.state = State::kStored};
  const auto masked = static_cast<Uint16>(status & 0xFF00);
  if ((status & 0xF000) == kWarnings)
    return {State::kStored, fmt::format("stored with a warning, status {:#06x}", status)};
  if (masked == kNoRoom) return {State::kNotSent, fmt::format("it has no room, status {:#06x}", status)};
  if (status == kNotAuthorized || status == kProcessingFailure)
    return {State::kNotSent, fmt::format("it cannot store now, status {:#06x}", status)};
  return {State::kRefused, fmt::format("it refuses the object, status {:#06x}", status)};
}

StoreOutcome store_file(DcmSCU& scu, const std::filesystem::path& path, const DicomContext& context) {
  using State = StoreOutcome::State;
  const auto id = scu.findAnyPresentationContextID(context.first.c_str(), context.second.front().c_str());
  if (id == 0) return {State::kRefused, std::string(kNotAccepted)};
  DcmFileFormat file;
  if (const OFCondition read = file.loadFile(path.c_str()); read.bad())
    return {State::kRefused, fmt::format("the file cannot be read ({})", printable(read.text()))};
  Uint16 status = 0;
  const OFCondition sent = scu.sendSTORERequest(id, "", file.getDataset(), status);
  if (sent.bad()) return {State::kNotSent, fmt::format("the connection broke ({})", printable(sent.text()))};
  return outcome_of(status);
}

}  // namespace

Result<std::vector<StoreOutcome>> store_files(const DicomPeer& peer,
                                              std::span<const std::filesystem::path> files) {
  using State = StoreOutcome::State;
  std::vector<Result<DicomContext>> of_files;
  std::vector<DicomContext> contexts;
  for (const std::filesystem::path& path : files) {
    of_files.push_back(context_of(path));
    const auto& context = of_files.back();
    if (context && std::ranges::find(contexts, *context) == contexts.end()) contexts.push_back(*context);
  }
  std::vector<StoreOutcome> outcomes;
  if (contexts.empty()) {
    for (const auto& context : of_files) outcomes.push_back({State::kRefused, context.error().message});
    return outcomes;
  }
  auto association = Association::open(peer, contexts);
  if (!association && association.error().code != ErrorCode::kUnsupported) return association.error();
  for (std::size_t at = 0; at < files.size(); ++at) {
    if (!of_files[at]) {
      outcomes.push_back({State::kRefused, of_files[at].error().message});
    } else if (!association) {
      outcomes.push_back({State::kRefused, std::string(kNotAccepted)});
    } else if (association->scu().isConnected()) {
      outcomes.push_back(store_file(association->scu(), files[at], *of_files[at]));
    } else {
      outcomes.push_back({State::kNotSent, "the connection had broken before"});
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
