// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/store.hpp"

#include "server/pacs/association.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "proto/base/printable.hpp"
#include "server/pacs/dicom_file.hpp"

namespace fanlight {

namespace {

// An archive on slow disks is not given up on: what it stores after that, it would get a second time.
constexpr int kStoreSeconds = 600;
constexpr int kAskSeconds = 60;
constexpr std::string_view kNotAccepted = "it does not accept objects of this kind, or not in this encoding";

/// A file's object, as its head describes it.
struct ObjectHead {
  DicomContext context;
  StoreOutcome problem;  ///< kNotTried where there is none
};

bool is_uncompressed(const std::string& syntax) {
  return syntax == UID_LittleEndianExplicitTransferSyntax || syntax == UID_LittleEndianImplicitTransferSyntax;
}

ObjectHead head_of(const std::filesystem::path& path) {
  const auto is_dicom = is_dicom_file(path);
  if (!is_dicom)
    return {.context = {},
            .problem = StoreOutcome::local(StoreOutcome::State::kNotSent, is_dicom.error().message)};
  DcmMetaInfo head;
  std::string sop_class;
  std::string syntax;
  OFString value;
  const bool loaded = *is_dicom && head.loadFile(path.c_str()).good();
  if (loaded && head.findAndGetOFString(DCM_MediaStorageSOPClassUID, value).good()) sop_class = value.c_str();
  if (loaded && head.findAndGetOFString(DCM_TransferSyntaxUID, value).good()) syntax = value.c_str();
  if (sop_class.empty() || syntax.empty())
    return {.context = {},
            .problem = StoreOutcome::local(StoreOutcome::State::kRefused,
                                           "the file is not DICOM, expected its meta information")};
  if (!is_uncompressed(syntax)) return {.context = {sop_class, {syntax}}, .problem = {}};
  return {.context = {sop_class,
                      {UID_LittleEndianExplicitTransferSyntax, UID_LittleEndianImplicitTransferSyntax}},
          .problem = {}};
}

/// A presentation context that the peer has accepted.
struct Accepted {
  T_ASC_PresentationContextID id = 0;  ///< 0: none
  E_TransferSyntax syntax = EXS_Unknown;
};

Accepted accepted(DicomScu& scu, const DicomContext& context) {
  for (const std::string& syntax : context.second) {
    const auto id = scu.findPresentationContextID(context.first.c_str(), syntax.c_str());
    if (id != 0) return {.id = id, .syntax = DcmXfer(syntax.c_str()).getXfer()};
  }
  return {};
}

/// Whether a file has not the structure of DICOM; any other failure may be one of the disk.
bool is_malformed(const OFCondition& problem) {
  return problem == EC_CorruptedData || problem == EC_InvalidTag || problem == EC_InvalidVR ||
         problem == EC_UnsupportedEncoding || problem == EC_ElemLengthLargerThanItem ||
         problem == EC_EndOfStream || problem == EC_StreamNotifyClient || problem == EC_InvalidStream ||
         problem == EC_SequDelimitationItemMissing || problem == EC_ItemDelimitationItemMissing;
}

/// What can fail before a byte is sent is looked for here: DCMTK does not tell such a failure from one of the
/// connection.
StoreOutcome store_file(DicomScu& scu, const std::filesystem::path& path, const DicomContext& context) {
  const Accepted as = accepted(scu, context);
  if (as.id == 0) return StoreOutcome::of_peer(StoreOutcome::State::kRefused, std::string(kNotAccepted));
  DcmFileFormat file;
  if (const OFCondition read = file.loadFile(path.c_str()); read.bad()) {
    const std::string problem =
        fmt::format("the file cannot be read ({}), expected whole DICOM", printable(read.text()));
    if (is_malformed(read)) return StoreOutcome::local(StoreOutcome::State::kRefused, problem);
    return StoreOutcome::local(StoreOutcome::State::kNotSent, problem);
  }
  DcmDataset& object = *file.getDataset();
  OFString value;
  if (object.findAndGetOFString(DCM_SOPInstanceUID, value).bad() || value.empty())
    return StoreOutcome::local(StoreOutcome::State::kRefused, "it has no SOP Instance UID, expected one");
  if (object.findAndGetOFString(DCM_SOPClassUID, value).bad() || value.c_str() != context.first)
    return StoreOutcome::local(StoreOutcome::State::kRefused,
                               "it has another SOP class than its head, expected the same");
  if (object.chooseRepresentation(as.syntax, nullptr).bad() || !object.canWriteXfer(as.syntax))
    return StoreOutcome::local(
        StoreOutcome::State::kRefused,
        "it cannot be written as the archive accepts it, expected pixels in one encoding");
  Uint16 status = 0;
  const OFCondition sent = scu.sendSTORERequest(as.id, "", &object, status);
  if (sent.good()) return outcome_of_status(status);
  (void)scu.abortAssociation();
  return StoreOutcome::of_peer(
      StoreOutcome::State::kNotSent,
      fmt::format("the connection broke ({}); an archive that does not know this title or machine does that",
                  printable(sent.text())));
}

}  // namespace

Result<std::vector<StoreOutcome>> store_files(const DicomPeer& peer,
                                              std::span<const std::filesystem::path> files,
                                              const std::atomic<bool>& stop) {
  std::vector<ObjectHead> heads;
  std::vector<DicomContext> contexts;
  for (const std::filesystem::path& path : files) {
    heads.push_back(head_of(path));
    const ObjectHead& head = heads.back();
    const bool can_be_sent = head.problem.state == StoreOutcome::State::kNotTried;
    if (can_be_sent && std::ranges::find(contexts, head.context) == contexts.end())
      contexts.push_back(head.context);
  }
  std::vector<StoreOutcome> outcomes;
  if (contexts.empty()) {
    for (ObjectHead& head : heads) outcomes.push_back(std::move(head.problem));
    return outcomes;
  }
  auto association = Association::open(peer, contexts, kStoreSeconds);
  if (!association && association.error().code != ErrorCode::kUnsupported) return association.error();
  int failures = 0;  // in a row
  for (std::size_t at = 0; at < files.size(); ++at) {
    ObjectHead& head = heads[at];
    if (head.problem.state != StoreOutcome::State::kNotTried) {
      outcomes.push_back(std::move(head.problem));
    } else if (!association) {
      outcomes.push_back(StoreOutcome::of_peer(StoreOutcome::State::kRefused, std::string(kNotAccepted)));
    } else if (association->scu().isConnected() && failures < kMostFailuresInARow && !stop) {
      outcomes.push_back(store_file(association->scu(), files[at], head.context));
      const StoreOutcome& outcome = outcomes.back();
      if (!outcome.is_local) failures = outcome.state == StoreOutcome::State::kNotSent ? failures + 1 : 0;
    } else {
      outcomes.emplace_back();
    }
  }
  return outcomes;
}

Result<void> check_echo(const DicomPeer& peer) {
  auto association = Association::open(
      peer, {{UID_VerificationSOPClass, {UID_LittleEndianImplicitTransferSyntax}}}, kAskSeconds);
  if (!association) return association.error();
  const OFCondition answered = association->scu().sendECHORequest(0);
  if (answered.good()) return {};
  return Error{ErrorCode::kUnavailable, fmt::format("{}: no answer to an echo ({}), expected one",
                                                    shown(peer), printable(answered.text()))};
}

}  // namespace fanlight
