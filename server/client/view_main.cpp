// SPDX-License-Identifier: Apache-2.0
// fanlight-view: a native display. `fanlight view` runs it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "proto/base/version.hpp"
#include "server/client/client_options.hpp"
#include "server/client/display_state.hpp"
#include "server/client/picture_window.hpp"
#include "server/client/stream_client.hpp"
#include "server/help/command_help.hpp"
#include "server/help/usage_sentence.hpp"

namespace fanlight {

namespace {

constexpr int kUsageError = 2;
constexpr std::chrono::milliseconds kTurn{8};  // a hand's input waits so long at most
constexpr std::int64_t kBetweenTriesNs = 2'000'000'000;
constexpr std::int64_t kMostSilenceNs = 6'000'000'000;    // the server sends a message once a second at least
constexpr std::int64_t kBetweenDrawingsNs = 100'000'000;  // for the age in the bar
constexpr double kZoomPerNotch = 1.1;
constexpr double kThresholdPerKey = 2;
constexpr std::uint32_t kJpegQuality = 92;
constexpr std::int64_t kSettledNs = 500'000'000;
// What a request may contain.
constexpr std::uint32_t kLeastSide = 16;
constexpr std::uint32_t kMostSide = 4096;

// On one line of the window.
constexpr const char* kKeys =
    "Space freeze · , . step · 1 2 4 9 panes · F1-F7 presets · drag turn · right drag light · wheel zoom · "
    "+ - threshold · R reset · F full screen · Q quit";
constexpr const char* kKeysHelp =
    "Keys: Space freeze; , . step; 1 2 4 9 panes; F1 to F7 presets; + - threshold;\n"
    "R reset; F full screen; Q quit. Drag to turn, with the right button to move the\n"
    "light; the wheel zooms.";

volatile std::sig_atomic_t interrupted = 0;

struct ViewOptions {
  ClientOptions client;
  bool full_screen = false;
};

/// One window and its connection to the server, which is made again where it is lost.
class View {
 public:
  View(const StreamClient::Config& server, PictureWindow& window) : server_(server), window_(window) {}

  Result<void> run() {
    if (auto connected = connect(); !connected) return connected;
    while (!ended_ && interrupted == 0) {
      take_inputs();
      follow_size(now_ns());
      if (client_) {
        take_messages();
      } else {
        wait_and_try();
      }
      if (const std::int64_t now = now_ns(); dirty_ || now - drawn_ns_ > kBetweenDrawingsNs) draw(now);
    }
    return {};
  }

 private:
  using Connected = Result<std::unique_ptr<StreamClient>>;

  Result<void> connect() { return begin(StreamClient::connect(server_)); }

  Result<void> begin(Connected client) {
    if (!client) return client.error();
    client_ = std::move(*client);
    state_.emplace(client_->hello());
    window_.forget_picture();  // it may be of another source
    heard_ns_ = now_ns();
    picture_width_ = client_->hello().picture_width();
    picture_height_ = client_->hello().picture_height();
    return ask_for_pictures();
  }

  /// As sharp as the window.
  Result<void> ask_for_pictures() {
    asked_size_ = window_.pixel_size();
    resized_ns_ = 0;
    v1::ClientMessage message;
    v1::StreamRequest& stream = *message.mutable_stream();
    stream.set_codec(v1::StreamRequest::JPEG);
    stream.set_quality(kJpegQuality);
    stream.set_width(std::clamp(asked_size_.width, kLeastSide, kMostSide));
    stream.set_height(std::clamp(asked_size_.height, kLeastSide, kMostSide));
    return client_->send(message);
  }

  /// Once the window has kept its size for a moment.
  void follow_size(std::int64_t now) {
    if (resized_ns_ == 0 || now - resized_ns_ < kSettledNs) return;
    resized_ns_ = 0;
    if (!client_ || window_.pixel_size() == asked_size_) return;
    if (auto sent = ask_for_pictures(); !sent) lose(sent.error().message);
  }

  void take_messages() {
    auto message = client_->next_within(kTurn);
    // Several may have come: the newest picture alone is worth drawing.
    std::optional<v1::Picture> newest;
    while (message && *message) {
      heard_ns_ = now_ns();
      state_->take(**message, heard_ns_);
      if (!(*message)->picture().jpeg().empty()) newest = std::move(*(*message)->mutable_picture());
      message = client_->next_within(std::chrono::milliseconds(0));
    }
    if (newest) show(*newest);
    if (!message) return lose(message.error().message);
    // The way to the server may be cut without an end of the connection.
    if (now_ns() - heard_ns_ > kMostSilenceNs) lose("the server does not answer");
  }

  void show(const v1::Picture& picture) {
    if (auto taken = window_.take_jpeg(picture.jpeg()); taken) {
      state_->shown(picture);
    } else {
      std::fprintf(stderr, "%s\n", taken.error().message.c_str());
    }
    dirty_ = true;
  }

  void lose(const std::string& reason) {
    client_.reset();
    state_->lose(reason + "; trying again");
    tried_ns_ = now_ns();
    dirty_ = true;
  }

  /// Connects on another thread, which is left behind at the end: a host that is off takes ten seconds.
  void wait_and_try() {
    SDL_Delay(static_cast<Uint32>(kTurn.count()));
    if (!coming_.valid()) {
      if (now_ns() - tried_ns_ < kBetweenTriesNs) return;
      std::packaged_task<Connected()> task([server = server_] { return StreamClient::connect(server); });
      coming_ = task.get_future();
      std::thread(std::move(task)).detach();
    }
    if (coming_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    if (auto connected = begin(coming_.get()); !connected) lose(connected.error().message);
  }

  void send(const v1::ClientMessage& message) {
    if (!client_) return;
    if (auto sent = client_->send(message); !sent) lose(sent.error().message);
  }
  void send(const std::optional<v1::ClientMessage>& message) {
    if (message) send(*message);
  }

  void take_inputs() {
    SDL_Event event;
    double right_px = 0;
    double down_px = 0;
    std::optional<SDL_FPoint> light;
    while (SDL_PollEvent(&event) != 0) {
      if (event.type == SDL_MOUSEMOTION && (event.motion.state & SDL_BUTTON_LMASK) != 0) {
        right_px += event.motion.xrel;
        down_px += event.motion.yrel;
      } else if (event.type == SDL_MOUSEMOTION && (event.motion.state & SDL_BUTTON_RMASK) != 0) {
        light = at(event.motion.x, event.motion.y);
      } else if (event.type == SDL_MOUSEBUTTONDOWN && event.button.button == SDL_BUTTON_RIGHT) {
        light = at(event.button.x, event.button.y);
      } else {
        take(event);
      }
    }
    if (!client_) return;
    // Several movements come to one request: the server would render the last one alone anyway.
    const double scale = window_.pixels_per_point(picture_height_);
    if (right_px != 0 || down_px != 0) send(state_->turn(right_px * scale, down_px * scale));
    if (light) send(state_->light_to(light->x, light->y));
  }

  SDL_FPoint at(int x, int y) const { return window_.picture_point(x, y, picture_width_, picture_height_); }

  void take(const SDL_Event& event) {
    switch (event.type) {
      case SDL_QUIT:
        ended_ = true;
        return;
      case SDL_WINDOWEVENT:
        dirty_ = true;
        if (event.window.event == SDL_WINDOWEVENT_SIZE_CHANGED) resized_ns_ = now_ns();
        return;
      case SDL_MOUSEWHEEL:
        if (client_ && event.wheel.y != 0) send(state_->zoom(std::pow(kZoomPerNotch, -event.wheel.y)));
        return;
      case SDL_KEYDOWN:
        return press(event.key.keysym.sym, event.key.repeat != 0);
      default:
        return;
    }
  }

  void press(SDL_Keycode key, bool repeated) {
    if (key == SDLK_q) {
      ended_ = true;
    } else if (key == SDLK_ESCAPE) {
      window_.leave_full_screen();
    } else if ((key == SDLK_f || key == SDLK_F11) && !repeated) {
      window_.toggle_full_screen();
    } else if (client_ && (!repeated || repeats(key))) {
      send(request_of(key));
    }
  }

  static bool repeats(SDL_Keycode key) {
    return key != SDLK_SPACE && key != SDLK_r && (key < SDLK_F1 || key > SDLK_F12);
  }

  std::optional<v1::ClientMessage> request_of(SDL_Keycode key) {
    constexpr double kStepPx = 8;
    switch (key) {
      case SDLK_SPACE:
        return state_->freeze_or_live();
      case SDLK_COMMA:
        return state_->step(-1);
      case SDLK_PERIOD:
        return state_->step(1);
      case SDLK_1:
        return state_->mode("surface");
      case SDLK_2:
        return state_->mode("surface-and-volume");
      case SDLK_4:
        return state_->mode("slices");
      case SDLK_9:
        return state_->mode("tomography");
      case SDLK_F1:
      case SDLK_F2:
      case SDLK_F3:
      case SDLK_F4:
      case SDLK_F5:
      case SDLK_F6:
      case SDLK_F7:
        return state_->preset(key - SDLK_F1);
      case SDLK_PLUS:
      case SDLK_KP_PLUS:
      case SDLK_EQUALS:
        return state_->threshold_by(kThresholdPerKey);
      case SDLK_MINUS:
      case SDLK_KP_MINUS:
        return state_->threshold_by(-kThresholdPerKey);
      case SDLK_LEFT:
        return state_->turn(-kStepPx, 0);
      case SDLK_RIGHT:
        return state_->turn(kStepPx, 0);
      case SDLK_UP:
        return state_->turn(0, -kStepPx);
      case SDLK_DOWN:
        return state_->turn(0, kStepPx);
      case SDLK_r:
        return state_->reset();
      default:
        return std::nullopt;
    }
  }

  void draw(std::int64_t now) {
    PictureWindow::Texts texts{.condition = state_->condition(now), .title = state_->title(), .hint = kKeys};
    if (client_ && state_->is_relayed()) texts.reach = "Sent outside";
    const v1::CineStatus& cine = state_->cine();
    if (client_ && cine.state() != v1::CineStatus::LIVE)
      texts.on_bar = fmt::format("volume {} of {}, for all displays", cine.volume() + 1, cine.volumes());
    if (const std::string refusal = state_->refusal(now); !refusal.empty()) {
      texts.hint = refusal;
      texts.hint_is_refusal = true;
    }
    window_.draw(texts);
    drawn_ns_ = now;
    dirty_ = false;
  }

  StreamClient::Config server_;
  PictureWindow& window_;
  std::unique_ptr<StreamClient> client_;  // null while the connection is lost
  std::optional<DisplayState> state_;
  double picture_width_ = 0;  // the usual size, in which the server counts
  double picture_height_ = 0;
  PictureSize asked_size_;
  std::int64_t resized_ns_ = 0;    // 0: the window has the size that was asked for
  std::future<Connected> coming_;  // of a try that is under way
  std::int64_t heard_ns_ = 0;
  std::int64_t tried_ns_ = 0;
  std::int64_t drawn_ns_ = 0;
  bool dirty_ = true;
  bool ended_ = false;
};

Result<void> view(const ViewOptions& options) {
  auto server = options.client.config();
  if (!server) return server.error();
  if (server->name.empty()) server->name = "native display";
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  const auto window = PictureWindow::open("Fanlight", options.full_screen);
  if (!window) return window.error();
  return View(*server, **window).run();
}

int run(int argc, char** argv) {
  CLI::App program("Show the picture in a window or full screen.", "fanlight view");
  program.footer(kKeysHelp);
  program.set_version_flag("-V,--version", version(), "Print the version and exit");
  ViewOptions options;
  options.client.add_to(program);
  program.add_flag("--full-screen", options.full_screen, "Use the full screen");
  use_command_help(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    const UsageError wrong = usage_error(program, error);
    std::fprintf(stderr, "%s: %s\n", wrong.command.c_str(), printable(wrong.sentence).c_str());
    return kUsageError;
  }
  if (const auto done = view(options); !done) {
    std::fprintf(stderr, "fanlight view: %s\n", printable(done.error().message).c_str());
    return done.error().code == ErrorCode::kInvalidArgument ? kUsageError : 1;
  }
  return 0;
}

}  // namespace

}  // namespace fanlight

int main(int argc, char** argv) {
  try {
    return fanlight::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fanlight view: %s\n", error.what());
    return 1;
  }
}
