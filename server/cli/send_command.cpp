// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "proto/base/printable.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/end_signals.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/pacs_options.hpp"
#include "server/pacs/clip_object.hpp"
#include "server/pacs/identity_json.hpp"
#include "server/pacs/outbox.hpp"
#include "server/pacs/picture_object.hpp"
#include "server/pacs/store.hpp"

namespace fanlight {

namespace {

struct SendOptions {
  std::vector<std::string> files;
  PacsOptions pacs;
  std::string patient;
  std::string queue;
  double clip_rate = 0;
  bool follow = false;
  bool json = false;
};

constexpr long kFirstPauseMs = 2'000;
constexpr long kLongestPauseMs = 300'000;
constexpr long kLookMs = 1'000;  // for new files in the queue

/// A folder of this process's own, which is removed at the end.
class TemporaryQueue {
 public:
  TemporaryQueue() {
    std::string name = (std::filesystem::temp_directory_path() / "fanlight-send-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = name;
  }
  TemporaryQueue(const TemporaryQueue&) = delete;
  TemporaryQueue& operator=(const TemporaryQueue&) = delete;
  ~TemporaryQueue() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Pictures become objects of one series; DICOM files stay what they are.
Result<void> put_in(Outbox& outbox, const SendOptions& options) {
  DicomIdentity identity;
  if (!options.patient.empty()) {
    auto read = read_identity(options.patient);
    if (!read) return read.error();
    identity = std::move(*read);
  }
  DicomSeries series = DicomSeries::begin(std::move(identity));
  if (options.clip_rate > 0) {
    const std::vector<std::filesystem::path> frames(options.files.begin(), options.files.end());
    const auto object = clip_object(frames, options.clip_rate, series);
    return object ? outbox.add(*object) : object.error();
  }
  for (const std::string& file : options.files) {
    if (std::filesystem::path(file).extension() == ".dcm") {
      if (auto added = outbox.add_file(file); !added) return added;
      continue;
    }
    const auto object = picture_file_object(file, series);
    if (!object) return object.error();
    if (auto added = outbox.add(*object); !added) return added;
  }
  return {};
}

void print_report(const SendOptions& options, const Outbox::Report& report, std::uint64_t waiting) {
  if (options.json) {
    fmt::print("{}\n", json_text({{"stored", report.stored},
                                  {"refused", report.refused},
                                  {"waiting", waiting},
                                  {"message", report.sentence}}));
    return;
  }
  std::string text = fmt::format("{}: {} stored", printable(options.pacs.peer), report.stored);
  if (report.refused > 0) text += fmt::format(", {} refused", report.refused);
  if (waiting > 0) text += fmt::format(", {} waiting", waiting);
  fmt::print("{}\n", text);
  if (report.refused == 0 && !report.sentence.empty()) fmt::print("note: {}\n", report.sentence);
}

/// Why not everything is stored, and where the rest is.
Error not_all(const SendOptions& options, const Error& cause, std::uint64_t waiting, bool refused) {
  std::string text = cause.message;
  if (waiting > 0 && !options.queue.empty()) {
    text += fmt::format("; {} {} in {} for the next attempt", waiting, waiting == 1 ? "waits" : "wait",
                        printable(options.queue));
  }
  if (refused && !options.queue.empty())
    text += fmt::format("; what was refused is in {}", printable(options.queue + "/refused"));
  return {cause.code, text};
}

Result<void> send_once(Outbox& outbox, const DicomPeer& peer, const SendOptions& options) {
  const auto is_sender = outbox.become_sender();
  if (!is_sender) return is_sender.error();
  if (!*is_sender) {
    print_report(options, {.sentence = "another program sends from this folder"}, outbox.waiting());
    return {};
  }
  const auto report = outbox.send(peer);
  const std::uint64_t waiting = outbox.waiting();
  if (!report) return not_all(options, report.error(), waiting, false);
  print_report(options, *report, waiting);
  if (waiting + report->refused == 0) return {};
  return not_all(options, {ErrorCode::kUnavailable, report->sentence}, waiting, report->refused > 0);
}

/// Sends what comes into the queue until a signal; waits longer and longer for an archive that is absent.
Result<void> send_until_signal(Outbox& outbox, const DicomPeer& peer, const SendOptions& options) {
  const auto is_sender = outbox.become_sender();
  if (!is_sender) return is_sender.error();
  if (!*is_sender) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{}: another program sends from this folder, expected one sender",
                             printable(options.queue))};
  }
  EndSignals signals;
  long pause_ms = kFirstPauseMs;
  std::string said;
  for (;;) {
    bool waits = false;
    if (outbox.waiting() > 0) {
      const auto report = outbox.send(peer);
      const std::string sentence = report ? report->sentence : report.error().message;
      waits = outbox.waiting() > 0;
      if (report && report->stored + report->refused > 0) print_report(options, *report, outbox.waiting());
      if (!sentence.empty() && sentence != said) fmt::print(stderr, "fanlight send: {}\n", sentence);
      said = sentence;
      (void)std::fflush(stdout);
    }
    if (!waits) pause_ms = kFirstPauseMs;
    if (signals.wait_ms(waits ? pause_ms : kLookMs)) return {};
    if (waits) pause_ms = std::min(2 * pause_ms, kLongestPauseMs);
  }
}

Result<void> send(const SendOptions& options) {
  const auto peer = options.pacs.dicom_peer();
  if (!peer) return peer.error();
  if (options.files.empty() && options.queue.empty()) {
    if (auto answered = check_echo(*peer); !answered) return answered;
    fmt::print("{}: answers\n", shown(*peer));
    return {};
  }
  std::optional<TemporaryQueue> temporary;
  if (options.queue.empty()) temporary.emplace();
  auto outbox = Outbox::open(temporary ? temporary->path() : std::filesystem::path(options.queue));
  if (!outbox) return outbox.error();
  if (auto added = put_in(*outbox, options); !added) return added;
  return options.follow ? send_until_signal(*outbox, *peer, options) : send_once(*outbox, *peer, options);
}

}  // namespace

Command add_send_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("send", "Send pictures and volumes to a DICOM archive (PACS)");
  const auto options = std::make_shared<SendOptions>();
  command
      ->add_option(
          "FILE", options->files,
          "Pictures, which become Secondary Capture images, and DICOM files, such as volumes of fanlight "
          "convert. Without one, what waits in the queue is sent, or the archive is asked for an echo")
      ->type_name("FILE");
  command->add_option("--to", options->pacs.peer, "Archive, TITLE@HOST:PORT")->required()->type_name("PEER");
  command
      ->add_option(
          "--patient", options->patient,
          "JSON file with the patient and the order, as fanlight worklist saves it; fields: patient_name, "
          "patient_id, birth_date, sex, accession_number, study_uid and others. Without it, the objects name "
          "no patient")
      ->type_name("FILE");
  command
      ->add_option("--clip", options->clip_rate,
                   "Send the files, which are JPEG, as one clip with this many frames a second")
      ->check(CLI::Range(0.1, 1000.0))
      ->type_name("RATE");
  auto* const queue = command
                          ->add_option("--queue", options->queue,
                                       "Folder in which files wait until the archive has stored them. It "
                                       "shows patients: keep it on an "
                                       "encrypted disk")
                          ->type_name("FOLDER");
  command
      ->add_flag("--follow", options->follow,
                 "Send what comes into the queue until a signal; retry after 2 s to 5 min while the archive "
                 "is absent")
      ->needs(queue);
  command->add_flag("--json", options->json, "Print the report as JSON");
  options->pacs.add_to(*command);
  return [options] { return send(*options); };
}

}  // namespace fanlight
