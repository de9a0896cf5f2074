// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/base/printable.hpp"
#include "proto/base/scratch_folder.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/end_request.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/pacs_options.hpp"
#include "server/pacs/clip_object.hpp"
#include "server/pacs/dicom_file.hpp"
#include "server/pacs/identity_json.hpp"
#include "server/pacs/outbox.hpp"
#include "server/pacs/patient_check.hpp"
#include "server/pacs/picture_object.hpp"

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

void note_missing_id(const DicomIdentity& patient) {
  if (!patient.patient_id.empty()) return;
  fmt::print(stderr,
             "fanlight send: note: no patient_id in --patient FILE; archives may not file such pictures\n");
}

/// The bytes of a picture's object, or nothing for a file that is DICOM already, and of the patient.
Result<std::optional<std::vector<std::uint8_t>>> object_of(const std::string& file,
                                                           const DicomIdentity& patient,
                                                           DicomSeries& series) {
  const auto is_dicom = is_dicom_file(file);
  if (!is_dicom) return is_dicom.error();
  if (*is_dicom) {
    if (auto same = check_same_patient(file, patient); !same) return same.error();
    return std::optional<std::vector<std::uint8_t>>();
  }
  auto object = picture_file_object(file, series);
  if (!object) return object.error();
  return std::optional(std::move(*object));
}

/// Stages the files one by one; what was staged before a failure stays in `staged`.
Result<void> stage_each(Outbox& outbox, const SendOptions& options, const DicomIdentity& patient,
                        DicomSeries& series, const std::atomic<bool>& stop,
                        std::vector<std::filesystem::path>& staged) {
  bool has_picture = false;
  for (const std::string& file : options.files) {
    if (stop) return Error{ErrorCode::kUnavailable, "ended by a signal"};
    const auto object = object_of(file, patient, series);
    if (!object) return object.error();
    if (*object && !std::exchange(has_picture, true)) note_missing_id(patient);
    auto path = *object ? outbox.stage(**object, file) : outbox.stage_file(file);
    if (!path) return path.error();
    staged.push_back(std::move(*path));
  }
  return {};
}

/// Pictures become objects of one series; DICOM files stay what they are. All of them are put in, or none.
Result<void> put_in(Outbox& outbox, const SendOptions& options, const std::atomic<bool>& stop) {
  DicomIdentity identity;
  if (!options.patient.empty()) {
    auto read = read_identity(options.patient);
    if (!read) return read.error();
    identity = std::move(*read);
  }
  DicomSeries series = DicomSeries::begin(identity);
  if (options.clip_rate > 0) {
    const std::vector<std::filesystem::path> frames(options.files.begin(), options.files.end());
    note_missing_id(identity);
    const auto object = clip_object(frames, options.clip_rate, series);
    if (!object) return object.error();
    const auto path = outbox.stage(*object, "the clip");
    return path ? outbox.publish({&*path, 1}) : path.error();
  }
  std::vector<std::filesystem::path> staged;
  const auto all = stage_each(outbox, options, identity, series, stop, staged);
  if (all) return outbox.publish(staged);
  Outbox::discard(staged);
  const std::string_view none = options.files.size() > 1 ? "; none of the files was sent" : "";
  return Error{all.error().code, fmt::format("{}{}", all.error().message, none)};
}

/// What has not been sent: it waits in a queue, or is lost with this call.
std::string rest_of(const SendOptions& options, std::uint64_t waiting) {
  return fmt::format("{} {}", waiting, options.queue.empty() ? "not sent" : "waiting");
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
  if (waiting > 0) text += ", " + rest_of(options, waiting);
  fmt::print("{}\n", text);
  if (report.refused + waiting == 0 && !report.sentence.empty()) fmt::print("note: {}\n", report.sentence);
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

/// Becomes the sender of the queue. One that is about to end may have looked for files the last time already.
Result<bool> become_sender(Outbox& outbox, const EndRequest& end) {
  constexpr int kTries = 10;
  for (int tries = 0; tries < kTries && outbox.waiting() > 0 && !end.asked(); ++tries) {
    auto is_sender = outbox.become_sender();
    if (!is_sender || *is_sender) return is_sender;
    (void)end.wait_ms(100);
  }
  return outbox.become_sender();
}

Result<void> send_once(Outbox& outbox, const SendOptions& options, const EndRequest& end) {
  const auto is_sender = become_sender(outbox, end);
  if (!is_sender) return is_sender.error();
  if (!*is_sender) {
    const Outbox::Report report{.sentence = "another program sends from this folder"};
    print_report(options, report, outbox.waiting());
    if (!options.json) fmt::print("note: {}\n", report.sentence);
    return {};
  }
  const auto report = outbox.send(Outbox::Which::kAll, end.asked());
  const std::uint64_t waiting = outbox.waiting();
  const Error ended{ErrorCode::kUnavailable, "ended by a signal"};
  if (!report) return not_all(options, end.asked() ? ended : report.error(), waiting, false);
  print_report(options, *report, waiting);
  if (waiting + report->refused == 0) return {};
  std::string why = end.asked() ? ended.message : report->sentence;
  if (why.empty()) why = "files came while the last ones were sent";
  return not_all(options, {ErrorCode::kUnavailable, why}, waiting, report->refused > 0);
}

/// Sends, and reports what has changed since `said`. Whether the archive can be asked for new files.
bool send_and_say(Outbox& outbox, Outbox::Which which, const SendOptions& options, const EndRequest& end,
                  std::string& said) {
  const auto report = outbox.send(which, end.asked());
  const std::string sentence = report ? report->sentence : report.error().message;
  if (report && report->stored + report->refused > 0) print_report(options, *report, outbox.waiting());
  if (!sentence.empty() && sentence != said && !end.asked())
    fmt::print(stderr, "fanlight send: {}\n", sentence);
  said = sentence;
  (void)std::fflush(stdout);
  return report && report->reached;
}

/// Sends what comes into the queue until a signal. What fails is tried again after longer and longer pauses;
/// what comes meanwhile is sent at once where the archive answers.
Result<void> send_until_signal(Outbox& outbox, const SendOptions& options, const EndRequest& end) {
  const auto is_sender = outbox.become_sender();
  if (!is_sender) return is_sender.error();
  if (!*is_sender) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{}: another program sends from this folder, expected one sender",
                             printable(options.queue))};
  }
  long pause_ms = kFirstPauseMs;
  long until_all_ms = 0;
  bool reached = true;
  std::string said;
  while (!end.asked()) {
    if (outbox.waiting() == 0) {
      pause_ms = kFirstPauseMs;
      until_all_ms = 0;
      reached = true;
    } else if (until_all_ms <= 0) {
      reached = send_and_say(outbox, Outbox::Which::kAll, options, end, said);
      until_all_ms = pause_ms;
      pause_ms = std::min(2 * pause_ms, kLongestPauseMs);
    } else if (reached && outbox.has_untried()) {
      reached = send_and_say(outbox, Outbox::Which::kUntried, options, end, said);
    }
    if (end.wait_ms(kLookMs)) break;
    until_all_ms -= kLookMs;
  }
  return {};
}

Result<void> send(const SendOptions& options) {
  auto archive = options.pacs.archive();
  if (!archive) return archive.error();
  if (options.files.empty() && options.clip_rate > 0)
    return Error{ErrorCode::kInvalidArgument, "--clip without files, expected JPEG files"};
  if (options.files.empty() && options.queue.empty()) {
    if (auto answered = archive->check(); !answered) return answered;
    fmt::print("{}: answers\n", archive->name);
    return {};
  }
  std::optional<ScratchFolder> temporary;
  if (options.queue.empty()) {
    if (auto made = temporary.emplace("fanlight-send").check(); !made) return made;
  }
  const EndRequest end([&temporary] {
    if (temporary) temporary->remove();
    fmt::print(stderr, "fanlight send: ended by a signal, since what it was doing took over {} s\n",
               EndRequest::kGraceMs / 1000);
  });
  auto outbox =
      Outbox::open(temporary ? temporary->path() : std::filesystem::path(options.queue), std::move(*archive));
  if (!outbox) return outbox.error();
  if (auto added = put_in(*outbox, options, end.asked()); !added) return added;
  return options.follow ? send_until_signal(*outbox, options, end) : send_once(*outbox, options, end);
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
  command
      ->add_option("--to", options->pacs.peer,
                   "Archive: TITLE@HOST:PORT, or the URL of a DICOMweb service, https://...")
      ->required()
      ->type_name("PEER");
  command
      ->add_option(
          "--patient", options->patient,
          "JSON file with the patient and the order, as fanlight worklist saves it; fields: patient_name, "
          "patient_id, birth_date, sex, accession_number, study_uid and others. Without it, the objects name "
          "no patient. DICOM files keep their own, which must be the same")
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
  command
      ->add_option("--http-login", options->pacs.http_login,
                   "File with USER:PASSWORD or Bearer TOKEN for a DICOMweb service")
      ->type_name("FILE");
  options->pacs.add_to(*command);
  return [options] { return send(*options); };
}

}  // namespace fanlight
