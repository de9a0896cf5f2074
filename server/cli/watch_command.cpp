// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "proto/model/scene.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/named_option.hpp"
#include "server/cli/watch_report.hpp"
#include "server/client/client_options.hpp"
#include "server/client/server_url.hpp"
#include "server/client/stream_client.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

struct WatchOptions {
  ClientOptions client;
  std::vector<std::string> changes;
  std::vector<std::string> replay;
  std::string save;
  std::uint64_t pictures = 0;
  double seconds = 0;
  bool json = false;
  bool take_over = false;
  bool own_view = false;
  v1::StreamRequest::Codec codec = v1::StreamRequest::JPEG;
  v1::StreamRequest stream;
};

// The server sends statistics once a second.
constexpr std::chrono::milliseconds kSilence{2000};

std::atomic<bool> interrupted = false;

Result<v1::Scene> change_of(const std::vector<std::string>& items) {
  v1::Scene change;
  for (const std::string& item : items) {
    const std::size_t equals = item.find('=');
    const std::string name = item.substr(0, equals);
    const auto refused = [&](const std::string& why) {
      return Error{ErrorCode::kInvalidArgument, fmt::format("--set {}", why)};
    };
    if (equals == std::string::npos || equals == 0)
      return refused(fmt::format("{}: expected NAME=VALUE, such as light.up_mm=20", printable(item)));
    const SceneField* const field = find_scene_field(name);
    if (field == nullptr) return refused(no_scene_field(name).message);
    Scene scene;
    if (auto set = set_field(scene, *field, std::string_view(item).substr(equals + 1)); !set)
      return refused(set.error().message);
    if (field->is_text()) {
      put_change(change, *field, field->get_text(scene));
    } else {
      put_change(change, *field, field->get(scene));
    }
  }
  return change;
}

/// Watches one stream until the options or a signal end it.
class Watch {
 public:
  /// `change`: what --set asks for. The options and the client must outlive this.
  Watch(const WatchOptions& options, v1::Scene change, StreamClient& client)
      : options_(options), change_(std::move(change)), client_(client) {}

  Result<void> run() {
    auto ended = read_until_end();
    report_rest();
    return ended;
  }

 private:
  Result<void> read_until_end() {
    if (auto asked = ask(); !asked) return asked;
    const std::int64_t from_ns = now_ns();
    while (!interrupted) {
      auto message = client_.next_within(kSilence);
      if (!message && interrupted) break;
      if (!message) return message.error();
      if (!*message) {
        report_silence();
      } else if (auto taken = take(**message); !taken) {
        return taken;
      }
      if (options_.pictures > 0 && pictures_ >= options_.pictures) break;
      if (options_.seconds > 0 && static_cast<double>(now_ns() - from_ns) / 1e9 >= options_.seconds) break;
    }
    return {};
  }

  Result<void> ask() {
    v1::ClientMessage stream;
    *stream.mutable_stream() = options_.stream;
    stream.mutable_stream()->set_codec(options_.codec);
    if (auto sent = client_.send(stream); !sent) return sent;
    if (options_.take_over) {
      v1::ClientMessage control;
      control.mutable_control()->set_wish(v1::ControlRequest::TAKE_OVER);
      if (auto sent = client_.send(control); !sent) return sent;
    }
    for (const std::string& wish : options_.replay) {
      auto request = replay_request(wish);
      if (!request) return request.error();
      v1::ClientMessage message;
      *message.mutable_replay() = *std::move(request);
      if (auto sent = client_.send(message); !sent) return sent;
    }
    if (options_.changes.empty()) return {};
    v1::ClientMessage message;
    if (options_.own_view) {
      message.mutable_view()->set_request_id(1);
      *message.mutable_view()->mutable_scene() = change_;
    } else {
      message.mutable_scene_change()->set_request_id(1);
      *message.mutable_scene_change()->mutable_scene() = change_;
    }
    return client_.send(message);
  }

  Result<void> take(const v1::ServerMessage& message) {
    switch (message.body_case()) {
      case v1::ServerMessage::kPicture:
        return take_picture(message.picture());
      case v1::ServerMessage::kLiveness:
        liveness_ = message.liveness();
        return {};
      case v1::ServerMessage::kStatistics:
        report(message.statistics());
        return {};
      case v1::ServerMessage::kScene:
        if (!message.scene().withdrawn().empty())
          fmt::print(stderr, "{}\n", printable(message.scene().withdrawn()));
        return {};
      case v1::ServerMessage::kSceneReply:
        if (message.scene_reply().has_refused()) return refused(message.scene_reply().refused());
        fmt::print(stderr, "the scene has revision {}\n", message.scene_reply().in_force().revision());
        return {};
      case v1::ServerMessage::kViewReply:
        if (message.view_reply().has_refused()) return refused(message.view_reply().refused());
        fmt::print(stderr, "the own view has revision {}\n", message.view_reply().in_force().revision());
        return {};
      case v1::ServerMessage::kView:
        if (message.view().ended().empty()) return {};
        return Error{ErrorCode::kStopped,
                     fmt::format("the server ended the own view: {}", message.view().ended())};
      case v1::ServerMessage::kSceneShown:
        fmt::print(stderr, "picture {} is the first with revision {}\n", message.scene_shown().picture_id(),
                   message.scene_shown().revision());
        return {};
      case v1::ServerMessage::kStreamReply:
        return message.stream_reply().has_refused() ? refused(message.stream_reply().refused())
                                                    : Result<void>();
      case v1::ServerMessage::kReplayReply:
        return message.replay_reply().has_refused() ? refused(message.replay_reply().refused())
                                                    : Result<void>();
      case v1::ServerMessage::kControlReply:
        return message.control_reply().has_refused() ? refused(message.control_reply().refused())
                                                     : Result<void>();
      case v1::ServerMessage::kError:
        return refused(message.error());
      default:
        return {};
    }
  }

  static Result<void> refused(const v1::Error& error) {
    return Error{ErrorCode::kUnavailable, error.message()};
  }

  Result<void> take_picture(const v1::Picture& picture) {
    // Pictures of the main view are sent until the own view has its first picture.
    if (options_.own_view && !options_.changes.empty() && !picture.private_view()) return {};
    ++pictures_;
    const std::string& bytes = !picture.jpeg().empty()  ? picture.jpeg()
                               : !picture.png().empty() ? picture.png()
                                                        : picture.h264();
    ++second_.pictures;
    second_.bytes += bytes.size();
    const std::int64_t age_ns = now_ns() + clock_ahead_ns_.value_or(0) - picture.capture_time_ns();
    if (clock_ahead_ns_) second_.ages_ms.push_back(static_cast<double>(age_ns) / 1e6);
    if (options_.save.empty()) return {};
    const char* const ending = !picture.jpeg().empty() ? "jpg" : "png";
    if (!picture.h264().empty()) return add_to_film(bytes);
    return replace_file(fmt::format("{}.{:06}.{}", options_.save, picture.picture_id(), ending), bytes);
  }

  /// H.264 goes to one file, which players expect, and which grows with each picture.
  Result<void> add_to_film(const std::string& bytes) const {
    const std::string path = options_.save + ".h264";
    std::ofstream file(path, pictures_ > 1 ? std::ios::binary | std::ios::app : std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (file) return {};
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} could not be written, expected an existing folder with free space", path)};
  }

  void report(const v1::Statistics& statistics) {
    const std::int64_t ahead_ns = statistics.server_time_ns() - now_ns();
    clock_ahead_ns_ = std::max(clock_ahead_ns_.value_or(ahead_ns), ahead_ns);
    statistics_ = statistics;
    print_second();
    heard_ns_ = now_ns();
  }

  /// The pictures after the last statistics.
  void report_rest() {
    if (second_.pictures > 0) print_second();
  }

  void print_second() {
    const v1::Statistics* const statistics = statistics_ ? &*statistics_ : nullptr;
    if (options_.json) {
      print_json(second_, liveness_, statistics);
    } else {
      print_text(second_, liveness_, statistics);
    }
    std::fflush(stdout);
    second_ = {};
  }

  /// The server has stopped, or the way to it.
  void report_silence() {
    report_rest();
    const double silent_s = static_cast<double>(now_ns() - heard_ns_) / 1e9;
    const std::string sentence = fmt::format("The server has not answered for {:.0f} s.", silent_s);
    if (options_.json) {
      const nlohmann::ordered_json report = {
          {"pictures", 0}, {"picture", "not live"}, {"silent_s", silent_s}, {"reason", sentence}};
      fmt::print("{}\n", json_text(report));
    } else {
      fmt::print("not live: {}\n", sentence);
    }
    std::fflush(stdout);
  }

  const WatchOptions& options_;
  const v1::Scene change_;
  StreamClient& client_;
  std::uint64_t pictures_ = 0;
  WatchedSecond second_;
  v1::Liveness liveness_;                       // the last one received
  std::optional<v1::Statistics> statistics_;    // likewise
  std::optional<std::int64_t> clock_ahead_ns_;  // the server's, by the message that was fastest on its way
  std::int64_t heard_ns_ = now_ns();            // when the last statistics came
};

Result<void> watch(const WatchOptions& options) {
  const auto server = options.client.config();
  if (!server) return server.error();
  const auto url = parse_server_url(server->url);
  if (!url) return url.error();
  auto change = change_of(options.changes);
  if (!change) return change.error();
  const auto client = StreamClient::connect(*server);
  if (!client) return client.error();
  const v1::Hello& hello = (*client)->hello();
  fmt::print(stderr, "{} {}: {} on {}, {} x {}; session {} as {}\n", url->text(),
             printable(hello.server_version()), printable(hello.source()), printable(hello.device()),
             hello.picture_width(), hello.picture_height(), hello.session_id(), v1::Role_Name(hello.role()));
  for (const std::string& note : hello.notes()) fmt::print(stderr, "note: {}\n", printable(note));
  // The server sends a message at least once a second, which ends the wait for the next one.
  std::signal(SIGINT, [](int) { interrupted = true; });
  std::signal(SIGTERM, [](int) { interrupted = true; });
  return Watch(options, *std::move(change), **client).run();
}

// The order of the options is that of --help.

void add_change_options(CLI::App& command, WatchOptions& options) {
  command
      .add_option("--set", options.changes,
                  "Change a field of the scene, such as light.up_mm=20; can be repeated")
      ->type_name("NAME=VALUE");
  command
      .add_option("--replay", options.replay,
                  "Control playback: play, pause, step=SWEEPS, seek=SECONDS, frame=NUMBER, speed=FACTOR "
                  "or ending=once, loop, to-and-fro; can be repeated")
      ->type_name("WISH");
  command.add_flag("--own-view", options.own_view,
                   "Change only the view of this display: its light, filters or camera");
  command.add_flag("--take-over", options.take_over, "Take the control from another display; admins only");
}

void add_output_options(CLI::App& command, WatchOptions& options) {
  command
      .add_option("--save", options.save, "Save pictures to PATH.000001.jpg and so on, or H.264 to PATH.h264")
      ->type_name("PATH");
  command.add_option("--pictures", options.pictures, "Exit after this many pictures")->type_name("N");
  command.add_option("--seconds", options.seconds, "Exit after this time")->type_name("S");
  command.add_flag("--json", options.json,
                   "Print statistics as a line of JSON per second, and one at the end for the rest");
}

void add_stream_options(CLI::App& command, WatchOptions& options) {
  add_named_option<v1::StreamRequest::Codec, v1::StreamRequest::Codec>(
      command, "--codec", options.codec,
      {{"jpeg", v1::StreamRequest::JPEG}, {"png", v1::StreamRequest::PNG}, {"h264", v1::StreamRequest::H264}},
      "Codec: jpeg (the default), png or h264");
  command
      .add_option_function<std::uint32_t>(
          "--quality", [&options](std::uint32_t value) { options.stream.set_quality(value); },
          "JPEG quality, 1 to 100")
      ->type_name("N");
  command
      .add_option_function<std::uint32_t>(
          "--kbps", [&options](std::uint32_t value) { options.stream.set_bit_rate_kbps(value); },
          "Approximate bit rate, kbit/s")
      ->type_name("N");
  command
      .add_option_function<double>(
          "--rate", [&options](double value) { options.stream.set_rate_hz(value); },
          "Maximum number of pictures per second")
      ->type_name("HZ");
  command
      .add_option_function<std::string>(
          "--size",
          [&options](const std::string& text) {
            unsigned width = 0;
            unsigned height = 0;
            if (std::sscanf(text.c_str(), "%ux%u", &width, &height) != 2)
              throw CLI::ValidationError("--size", "expected WIDTHxHEIGHT");
            options.stream.set_width(width);
            options.stream.set_height(height);
          },
          "Maximum size in pixels; the aspect ratio is kept")
      ->type_name("WxH");
}

}  // namespace

Command add_watch_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand(
      "watch", "Connect as a display: print statistics, save pictures, change the scene");
  const auto options = std::make_shared<WatchOptions>();
  options->client.add_to(*command);
  add_change_options(*command, *options);
  add_output_options(*command, *options);
  add_stream_options(*command, *options);
  return [options] { return watch(*options); };
}

}  // namespace fanlight
