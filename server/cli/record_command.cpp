// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <atomic>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/open_source.hpp"
#include "acquisition/record/frame_pump.hpp"
#include "acquisition/record/recorder.hpp"
#include "acquisition/record/recover_recording.hpp"
#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/end_signals.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/named_option.hpp"
#include "server/cli/probe_options.hpp"

namespace fanlight {

namespace {

struct RecordOptions {
  std::string input;
  SourceOptions playing;
  std::string out;
  PixelForm form = PixelForm::kRaw;
  double seconds = 0;
  double megabytes = 0;
  double last_s = 0;
  bool fast = false;
  bool real_time = false;
  bool json = false;
};

/// Frames that the recording lacks.
struct Losses {
  std::uint64_t by_source = 0;
  std::uint64_t interruptions = 0;  ///< of the source; not a number of frames
  std::uint64_t by_recorder = 0;    ///< the disk did not take them in time

  std::uint64_t all() const { return by_source + by_recorder; }
};

/// The source on a thread of its own, until it ends or stop() is called.
class Pump {
 public:
  Pump(FrameSource& source, FrameTap& tap, FullQueue full)
      : thread_([this, &source, &tap, full](const std::stop_token& stop) {
          result_ = pump_frames(source, tap, full, stop, pumped_);
          ended_.store(true, std::memory_order_release);
        }) {}
  bool ended() const { return ended_.load(std::memory_order_acquire); }
  /// Blocks until the source lets go.
  Result<void> stop() {
    thread_.request_stop();
    thread_.join();
    return result_;
  }
  /// After stop().
  const PumpedFrames& pumped() const { return pumped_; }

 private:
  Result<void> result_;
  PumpedFrames pumped_;
  std::atomic<bool> ended_{false};
  std::jthread thread_;
};

std::string size_text(std::uint64_t bytes) {
  const auto megabytes = static_cast<double>(bytes) * 1e-6;
  return megabytes < 1000 ? fmt::format("{:.1f} MB", megabytes) : fmt::format("{:.2f} GB", megabytes * 1e-3);
}

void show_progress(const RecordingStatus& status) {
  if (isatty(STDERR_FILENO) == 0) return;
  if (status.state == RecordingStatus::State::kFinishing) {
    fmt::print(stderr, "\r{}: writing the final file, {:.0f} %\x1b[K", status.file,
               100 * status.finish_share);
  } else {
    fmt::print(stderr, "\r{}: {:.1f} s, {} frames, {}{}\x1b[K", status.file, status.duration_s, status.frames,
               size_text(status.bytes), status.trouble.empty() ? "" : "; " + printable(status.trouble));
  }
  std::fflush(stderr);
}

nlohmann::ordered_json recording_json(const RecordingStatus& status, const Losses& losses) {
  return {{"file", status.last_file},
          {"frames", status.last_frames},
          {"bytes", status.last_bytes},
          {"duration_s", status.last_duration_s},
          {"files", status.finished},
          {"frames_missed", losses.by_recorder},
          {"frames_lost_by_source", losses.by_source},
          {"interruptions", losses.interruptions}};
}

std::string counted(std::uint64_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string losses_text(const Losses& losses) {
  std::string text =
      losses.all() == 0 ? "no frame lost" : fmt::format("{} lost", counted(losses.all(), "frame"));
  if (losses.by_source > 0) text += fmt::format(", {} before they reached Fanlight", losses.by_source);
  if (losses.by_recorder > 0) text += fmt::format(", {} because the disk was too slow", losses.by_recorder);
  if (losses.interruptions > 0)
    text += fmt::format("; the source was interrupted {}", counted(losses.interruptions, "time"));
  return text;
}

/// The last line is the result: the file, its frames, and the losses.
void print_recording(const RecordOptions& options, const RecordingStatus& status, const Losses& losses) {
  if (options.json) {
    fmt::print("{}\n", json_text(recording_json(status, losses)));
    return;
  }
  if (status.finished == 1 &&
      std::filesystem::path(status.last_file).extension() != std::filesystem::path(options.out).extension()) {
    fmt::print("There was no space for a copy of the pixels: they stay in a separate file.\n");
  }
  if (status.finished > 1) {
    fmt::print(
        "{} files in all: a new one begins when the geometry of the frames changes, or a file or the "
        "disk is full\n",
        status.finished);
  }
  fmt::print("{}: {} frames in {:.1f} s, {}; {}\n", status.last_file, status.last_frames,
             status.last_duration_s, size_text(status.last_bytes), losses_text(losses));
}

SourcePace pace_of(const RecordOptions& options) {
  if (options.fast) return SourcePace::kAsFastAsTaken;
  return options.real_time ? SourcePace::kRealTime : SourcePace::kPatient;
}

/// Nothing may be lost by a name that is taken, or a folder that is not there.
Result<void> check_name(const std::filesystem::path& path) {
  if (auto named = check_free_name(path); !named) return named;
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (access(folder.c_str(), W_OK | X_OK) == 0) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{} cannot be written, expected an existing, writable folder", folder.string())};
}

// A source that fell silent does not hold a recording of --seconds up any longer than this.
constexpr std::int64_t kSilenceNs = 5'000'000'000;

/// Waits until the source ends, the recording ends by its limits, or the user ends it. Prints progress and
/// trouble meanwhile. `seconds`: the limit by time; 0: none. `status`: the newest.
void watch_recording(EndSignals& signals, Recorder& recorder, const Pump& pump, double seconds,
                     RecordingStatus& status) {
  const std::int64_t begun_ns = now_ns();
  std::int64_t last_frame_ns = begun_ns;
  std::uint64_t frames = 0;
  std::string reported;
  for (;;) {
    const bool asked = signals.wait_ms(100);
    if (const RecordingStatus* newest = recorder.link().status.newest()) {
      status = *newest;
      show_progress(status);
      if (!status.trouble.empty() && status.trouble != reported)
        fmt::print(stderr, "fanlight record: {}; waiting for free space\n", printable(status.trouble));
      reported = status.trouble;
    }
    // While nothing is written, no frame's time reaches the limit.
    const double waited_s = static_cast<double>(now_ns() - begun_ns) * 1e-9;
    if (status.state == RecordingStatus::State::kNoRoom && seconds > 0 && waited_s > seconds) return;
    if (std::exchange(frames, status.frames) != status.frames) last_frame_ns = now_ns();
    const bool is_silent = now_ns() - last_frame_ns > kSilenceNs;
    if (is_silent && seconds > 0 && waited_s > seconds) {
      fmt::print(stderr, "fanlight record: no frame for {} s: the recording ends here\n",
                 kSilenceNs / 1'000'000'000);
      return;
    }
    const bool over = status.order_done > 0 && status.state != RecordingStatus::State::kRecording &&
                      status.state != RecordingStatus::State::kNoRoom;
    // A disk that takes nothing from the start is no recording that waits.
    const bool hopeless = status.state == RecordingStatus::State::kNoRoom && status.frames == 0;
    if (asked || over || hopeless || pump.ended()) return;
  }
}

Result<void> record(const RecordOptions& options) {
  EndSignals signals;
  if (auto named = check_name(options.out); !named) return named;
  Doorbell bell;
  ProbeLink probe(bell, bell);
  SourceOptions playing = options.playing;
  playing.pace = pace_of(options);
  playing.stopped = [&signals] { return signals.wait_ms(0); };
  if (const std::string note = opening_note(options.input, playing); !note.empty())
    fmt::print(stderr, "fanlight record: {}\n", note);
  auto source = open_source(options.input, playing, probe);
  if (!source) return source.error();

  Doorbell status_bell;
  Recorder recorder((*source)->description(), status_bell);
  const RecordingLink link = recorder.link();
  link.send({.number = 1,
             .wish = RecordingOrder::Wish::kRecord,
             .path = options.out,
             .form = options.form,
             .most_s = options.seconds,
             .most_bytes = static_cast<std::uint64_t>(options.megabytes * 1e6),
             .ring_s = options.last_s});
  RecordingStatus status;
  while (status.order_done == 0 && !status.over) {
    status_bell.wait(100'000'000);
    if (const RecordingStatus* newest = link.status.newest()) status = *newest;
  }
  const bool waits = (*source)->waits() && !options.real_time;
  Pump pump(**source, recorder.tap(), waits ? FullQueue::kWait : FullQueue::kLoseFrame);
  watch_recording(signals, recorder, pump, options.seconds, status);
  auto pumped = pump.stop();
  recorder.end(Recorder::Finish::kWait);
  if (const RecordingStatus* newest = recorder.link().status.newest()) status = *newest;
  if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\r\x1b[K");
  if (status.unfinished > 0 && status.finished == 1)
    return Error{ErrorCode::kUnavailable, status.last_trouble};
  if (status.finished == 0 && !pumped) return pumped;
  if (status.finished == 0) {
    return Error{ErrorCode::kNotFound, status.trouble.empty()
                                           ? "the source delivered no frame, expected at least one"
                                           : status.trouble};
  }
  for (const std::string& note : (*source)->description().notes)
    fmt::print(stderr, "note: {}\n", printable(note));
  const Losses losses{.by_source = pump.pumped().lost,
                      .interruptions = pump.pumped().interruptions,
                      .by_recorder = status.frames_missed};
  print_recording(options, status, losses);
  std::fflush(stdout);  // before an error
  if (status.unfinished > 0) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} of {} files could not be finished, expected fanlight recover to do so",
                             status.unfinished, status.finished)};
  }
  if (!status.trouble.empty()) return Error{ErrorCode::kUnavailable, status.trouble};
  if (pumped && losses.all() > 0 && !options.real_time) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} missing from the recording, expected none; use --real-time to accept losses",
                             counted(losses.all(), "frame"))};
  }
  return pumped;
}

Result<void> recover(const std::string& file, PixelForm form, bool json) {
  const auto recovered = recover_recording(file, {.form = form});
  if (!recovered) return recovered.error();
  if (json) {
    fmt::print("{}\n", json_text(nlohmann::ordered_json({{"file", recovered->path.string()},
                                                         {"frames", recovered->frames},
                                                         {"frames_damaged", recovered->frames_damaged},
                                                         {"frames_lost", recovered->frames_lost},
                                                         {"bytes", recovered->bytes},
                                                         {"duration_s", recovered->duration_s}})));
    return {};
  }
  fmt::print("{}: {} frames in {:.1f} s, {}\n", recovered->path.string(), recovered->frames,
             recovered->duration_s, size_text(recovered->bytes));
  if (recovered->frames_lost > 0)
    fmt::print("{} more were begun and are lost: not all that belongs to them was on the disk\n",
               recovered->frames_lost);
  if (recovered->frames_damaged > 0)
    fmt::print("{} of them are damaged and marked so: their pixels did not reach the disk\n",
               recovered->frames_damaged);
  return {};
}

void add_form(CLI::App& command, PixelForm& form) {
  add_named_option<PixelForm, PixelForm>(
      command, "--form", form, {{"raw", PixelForm::kRaw}, {"zlib", PixelForm::kZlib}},
      "Format of the pixels: raw (the default) or zlib, which compresses them when the recording ends");
}

}  // namespace

Command add_record_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("record", "Record a source to a PLUS sequence file");
  const auto options = std::make_shared<RecordOptions>();
  command
      ->add_option("SOURCE", options->input,
                   "usb:VENDOR:PRODUCT[:SERIAL] for a probe, igtl:HOST[:PORT] for a scanner by OpenIGTLink, "
                   "phantom: for the simulated probe, or a recording")
      ->required();
  command
      ->add_option("--out", options->out,
                   "Output file: x.igs.mha, or x.igs.mhd with the pixels in a separate file")
      ->required()
      ->type_name("FILE");
  add_form(*command, options->form);
  command
      ->add_option("--seconds", options->seconds,
                   "Stop after this time; 0: at the end of the source, or at Ctrl-C")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e6))
      ->type_name("S");
  command
      ->add_option("--megabytes", options->megabytes, "Stop after this many megabytes of pixels; 0: no limit")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("MB");
  command
      ->add_option("--last", options->last_s,
                   "Keep only the last seconds, which bounds the space on disk; 0: all")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e6))
      ->type_name("S");
  command
      ->add_option("--geometry", options->playing.geometry_path,
                   "TOML file with the geometry of the recording")
      ->type_name("FILE");
  CLI::Option* const fast = command->add_flag(
      "--fast", options->fast, "Read a recording or the simulated probe as fast as the disk allows");
  command
      ->add_flag(
          "--real-time", options->real_time,
          "Drop frames that arrive too late, as a real probe does, and do not treat lost frames as an error "
          "(otherwise the exit code is 1)")
      ->excludes(fast);
  command->add_flag("--json", options->json, "Print the report as JSON");
  add_probe_options(*command, options->playing);
  return [options]() { return record(*options); };
}

Command add_recover_command(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("recover", "Finish a recording that was cut off by a crash or a full disk");
  const auto file = std::make_shared<std::string>();
  const auto form = std::make_shared<PixelForm>(PixelForm::kRaw);
  const auto json = std::make_shared<bool>(false);
  command->add_option("FILE", *file, "File name of the recording")->required();
  add_form(*command, *form);
  command->add_flag("--json", *json, "Print the report as JSON");
  return [file, form, json]() { return recover(*file, *form, *json); };
}

}  // namespace fanlight
