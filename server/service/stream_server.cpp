// SPDX-License-Identifier: Apache-2.0
#include "server/service/stream_server.hpp"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "proto/base/clock.hpp"
#include "server/service/protobuf_tables.hpp"

namespace fanlight {

namespace asio = boost::asio;

namespace {

// Fewer connections than this are too few for a ward: the administrator is warned.
constexpr std::size_t kFewConnections = 256;

}  // namespace

StreamServer::StreamServer(const Config& config, const Dependencies& dependencies, AuditLog audit,
                           Authenticator access)
    : config_(config),
      dependencies_(dependencies),
      state_(config.state,
             {.ports = dependencies_.ports,
              .counters = dependencies.counters,
              .executor = executor(),
              .find_surface = dependencies.find_surface,
              .survey_answered = [this](const SurveyDesk::Answer& answer) { survey_answered(answer); },
              .measure_fluid = dependencies.measure_fluid,
              .fluid_answered = [this](const FluidDesk::Answer& answer) { commands_.fluid_answered(answer); },
              .presets_changed = [this] { preset_file_.presets_changed(); },
              .measurements_changed = [this] { measurement_files_.measurements_changed(); }}),
      hub_(dependencies.counters,
           {.executor = executor(),
            .threads = EncoderPool::usual_threads(),
            .usual_size = state_.description.picture_size,
            .wanted_sizes =
                [&sizes = dependencies.ports.render.wanted_sizes](const WantedSizes& wanted) {
                  sizes.draft() = wanted;
                  sizes.publish();
                }}),
      sessions_(state_.views),
      audit_(std::move(audit)),
      access_(std::move(access)),
      control_(config.control_lapse_ms),
      commands_(state_, control_,
                [this](Notice notice, std::uint64_t except) { sessions_.notify(notice, except); }),
      preset_file_(config.presets, state_.presets, executor()),
      measurement_files_(state_.description.path,
                         {.measurements = state_.measurements,
                          .executor = executor(),
                          .trouble_changed = [this] { sessions_.notify(Notice::kMeasurements); }}),
      messages_(state_, control_, hub_),
      requests_{.state = state_,
                .commands = commands_,
                .hub = hub_,
                .access = access_,
                .control = control_,
                .sessions = sessions_,
                .messages = messages_},
      streams_{.shared = requests_, .audit = audit_, .limits = config.session_limits},
      rest_api_({.state = state_,
                 .commands = commands_,
                 .hub = hub_,
                 .audit = audit_,
                 .sessions = sessions_,
                 .control = control_,
                 .access = access_}),
      http_{.state = state_,
            .hub = hub_,
            .audit = audit_,
            .access = access_,
            .rest_api = rest_api_,
            .stream = streams_,
            .hsts = config.hsts,
            .loopback_only = config.endpoint.address().is_loopback(),
            .allowed_origins = config_.allowed_origins},
      connection_limit_(config.most_connections, config.most_connections_a_host),
      listener_(loop_, {.endpoint = config.endpoint, .tls = config.tls},
                {.counters = dependencies.counters, .limit = connection_limit_, .http = http_}),
      access_files_(access_, listener_, audit_),
      source_watch_(state_, commands_, sessions_),
      recording_watch_(state_.recording, sessions_, audit_),
      scene_guard_(state_, sessions_, audit_),
      liveness_watch_(loop_, {.state = state_,
                              .hub = hub_,
                              .sessions = sessions_,
                              .scene = scene_guard_,
                              .other_clients = [this] { return other_clients(); },
                              .changed =
                                  [this] {
                                    if (igtl_) igtl_->state_changed();
                                  }}),
      signals_(loop_, {.end = [this] { end("the server is stopping"); },
                       .end_now = [this] { stop(); },
                       .read_again = [this] { read_again(); },
                       .log_state = [this] { log_state(); }}),
      second_(loop_, std::chrono::seconds(1), [this] { second_passed(); }) {
  build_protobuf_tables();
  if (config.igtl) {
    igtl_.emplace(loop_, *config.igtl,
                  IgtlServer::Dependencies{.state = state_,
                                           .commands = commands_,
                                           .audit = audit_,
                                           .hub = hub_,
                                           .executor = executor(),
                                           .ports = dependencies_.ports,
                                           .write_frame = dependencies_.write_frame,
                                           .wants_changed = [this] { liveness_watch_.update(); }});
  }
  if (config.rtp) {
    rtp_.emplace(loop_, *config.rtp,
                 RtpSender::Dependencies{.state = state_,
                                         .hub = hub_,
                                         .id = sessions_.next_id(),
                                         .executor = executor(),
                                         .changed = [this] { liveness_watch_.update(); }});
    state_.relay = &*rtp_;
  }
  access_.audit_to(audit_);
  sessions_.when_opened([this] { liveness_watch_.update(); });
  // The library would log a line for each malformed message; the sessions answer and count them.
  google::protobuf::SetLogHandler(nullptr);
}

Executor StreamServer::executor() {
  return [this](EncoderLane lane, std::function<void()> work, std::function<void()> done) {
    executor_.run(lane, std::move(work), std::move(done));
  };
}

Result<std::unique_ptr<StreamServer>> StreamServer::create(const Config& wanted,
                                                           const Dependencies& dependencies) {
  Config config = wanted;
  config.most_connections =
      std::min(config.most_connections, connections_within_limit(config.most_connections));
  if (config.most_connections < std::min(wanted.most_connections, kFewConnections)) {
    spdlog::warn(
        "there is room for {} connections only, since the system allows this process few open files "
        "(ulimit -n), expected {} or more",
        config.most_connections, wanted.most_connections + kOtherFiles);
  }
  AuditLog audit;
  if (!config.audit_log.empty()) {
    auto opened = AuditLog::open(config.audit_log, config.audit_rotate_bytes);
    if (!opened) return opened.error();
    audit = std::move(*opened);
    if (config.audit_required) audit.require();
  }
  auto access = Authenticator::create(config.credentials);
  if (!access) return access.error();
  std::unique_ptr<StreamServer> server(
      new StreamServer(config, dependencies, std::move(audit), std::move(*access)));
  server->preset_file_.load();
  server->measurement_files_.load();
  if (auto opened = server->open_archive(); !opened) return opened.error();
  if (auto listening = server->listener_.open(); !listening) return listening.error();
  if (server->igtl_) {
    if (auto listening = server->igtl_->open(); !listening) return listening.error();
  }
  // The stream descriptor closes its file descriptor, which belongs to the bell: so it gets a duplicate.
  server->bell_.assign(dup(dependencies.ports.render.to_server.file_descriptor()));
  return server;
}

Result<void> StreamServer::run() {
  const double session_mb =
      static_cast<double>(SessionLimits::most_bytes(state_.description.largest_picture_size)) / 1e6;
  spdlog::info("a display takes up to {:.1f} MB of memory; {} connections at most", session_mb,
               config_.most_connections);
  signals_.start();
  bell_rang();  // values may have come before
  start_relay();
  run_loop();
  signals_.release_ends();
  preset_file_.finish();
  measurement_files_.finish();
  close_audit();
  if (failure_) return *failure_;
  return {};
}

Result<void> StreamServer::open_archive() {
  if (!dependencies_.open_archive) return {};
  auto opened =
      dependencies_.open_archive([this](std::function<void()> work) { asio::post(loop_, std::move(work)); });
  if (!opened) return opened.error();
  archive_ = *std::move(opened);
  state_.archive = archive_.get();
  return {};
}

void StreamServer::run_loop() {
  for (;;) {
    try {
      start_chains();
      loop_.run();
      return;
    } catch (const std::bad_alloc&) {
      // It has ended one handler: that of a connection, which is closed by that, or one of the chains. Memory
      // may be free again a little later.
      dependencies_.counters.handlers_out_of_memory.add();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
}

void StreamServer::start_chains() {
  if (!ending_) listener_.start();
  if (!ending_ && igtl_) igtl_->start();
  if (!ending_ && rtp_) rtp_->keep_alive();
  if (bell_chain_.broken()) watch_bell();
  second_.start();
  liveness_watch_.start();
  signals_.start();
  if (ending_ && end_chain_.broken()) stop_without_sessions();
}

void StreamServer::fail(const Error& error) {
  if (!failure_) failure_ = error;
  end("the server is stopping after a failure");
}

void StreamServer::end(const std::string& reason) {
  if (std::exchange(ending_, true)) return;
  listener_.close();
  if (dependencies_.hooks.ends) dependencies_.hooks.ends();
  end_until_ns_ = now_ns() + config_.most_end_ms * 1'000'000;
  for (const auto& session : sessions_.all()) session->end(reason);
  if (igtl_) igtl_->end();
  if (rtp_) rtp_->stop();
  stop_without_sessions();
}

void StreamServer::stop_without_sessions() {
  const bool all_left =
      sessions_.all().empty() && (!igtl_ || igtl_->clients() == 0) && rest_api_.objects_under_way() == 0;
  if (now_ns() >= end_until_ns_ || all_left) return stop();
  end_pause_.expires_after(std::chrono::milliseconds(10));
  end_pause_.async_wait([this, link = end_chain_.link()](boost::system::error_code stopped) {
    if (!stopped) stop_without_sessions();
  });
}

void StreamServer::close_audit() {
  if (const std::size_t objects = rest_api_.objects_under_way(); objects > 0) {
    spdlog::warn("{} objects for the archive were under way at the end, and may be in its queue or not",
                 objects);
  }
  for (const auto& session : sessions_.all()) session->abandon();
  rest_api_.end_scripts();
  const bool written = audit_.close();
  if (const std::string notice = audit_.take_notice(); !notice.empty()) spdlog::warn("{}", notice);
  if (!written) spdlog::warn("the audit log was left, since its disk did not answer within 2 s");
  dependencies_.counters.audit_lines_lost.set(audit_.lines_lost());
  if (const AuditPosition newest = audit_.newest(); newest.line > 0) {
    spdlog::info("the audit log has {} lines, the newest with the hash {}", newest.line, newest.hash);
  }
}

void StreamServer::read_again() {
  if (ending_) return;
  if (dependencies_.hooks.read_again && !dependencies_.hooks.read_again()) {
    spdlog::info("SIGHUP: the terminal that started the server was closed, so the server stops");
    return end("the server is stopping");
  }
  spdlog::info(
      "SIGHUP: reloading configuration, tokens and certificates, and checking whether the audit log was "
      "moved");
  access_files_.reload(true);
  audit_.reopen();
  if (dependencies_.hooks.was_read_again) dependencies_.hooks.was_read_again();
}

void StreamServer::log_state() const {
  const ControlLease::Party& holder = control_.state().holder;
  const AuditPosition newest = audit_.newest();
  const std::string audit =
      newest.line == 0 ? ""
                       : fmt::format(", line {} of the audit log has the hash {}", newest.line, newest.hash);
  spdlog::info("SIGUSR1: {} sessions, in control: {}, source {}{}", sessions_.all().size(),
               holder.session == 0 ? "none" : holder.name, state_.source_state(), audit);
}

void StreamServer::watch_bell() {
  bell_.async_wait(asio::posix::descriptor_base::wait_read,
                   [this, link = bell_chain_.link()](boost::system::error_code failure) {
                     if (failure) return;
                     dependencies_.ports.render.to_server.wait(0);
                     bell_rang();
                     watch_bell();
                   });
}

void StreamServer::bell_rang() {
  source_watch_.update();
  if (recording_watch_.update())
    measurement_files_.recording_seen(state_.recording.status(), config_.state.recording.folder);
  take_answers();
  if (igtl_) igtl_->bell_rang();
  take_picture();
  liveness_watch_.update();
  rest_api_.picture_shown(now_ns());
  show_private_views();
}

/// What the render thread has reported.
void StreamServer::take_answers() {
  struct Taker {
    StreamServer& server;
    void operator()(const CineStatus& status) const {
      server.state_.cine.changed(status);
      server.sessions_.notify(Notice::kCine);
    }
    void operator()(VolumeAnswer& answer) const { server.state_.volumes.answered(std::move(answer)); }
    void operator()(const RenderHealth& health) const { server.state_.liveness.health_changed(health); }
    void operator()(const PrivateViewEnds& ends) const {
      server.end_views(server.state_.views.ended_by_renderer(ends));
    }
    void operator()(const Error& error) const { server.fail(error); }
  };
  while (auto answer = dependencies_.ports.render.answers.take()) std::visit(Taker{*this}, *answer);
}

void StreamServer::take_picture() {
  const Picture* const picture = dependencies_.ports.render.pictures.newest();
  if (picture == nullptr) return;
  state_.picture_shown(*picture, now_ns());
  if (state_.demand.resting()) return;
  hub_.show(*picture);
  if (igtl_) igtl_->show(*picture);
}

void StreamServer::survey_answered(const SurveyDesk::Answer& answer) {
  if (answer.asker != SurveyDesk::kServer) {
    commands_.survey_answered(answer);
  } else if (state_.default_view.answered(answer)) {
    sessions_.notify(Notice::kScene);
  }
}

void StreamServer::show_private_views() {
  for (const Picture* picture : state_.views.newest(now_ns())) hub_.show(*picture);
  if (!state_.views.has_more()) return;
  private_pause_.expires_after(std::chrono::nanoseconds(ViewAdmission::kBetweenPicturesNs));
  private_pause_.async_wait([this](boost::system::error_code stopped) {
    if (!stopped) show_private_views();
  });
}

void StreamServer::second_passed() {
  if (state_.liveness.driver_silent_ns() > config_.most_driver_ms * 1'000'000) {
    fail({ErrorCode::kLost,
          fmt::format("a call of the GPU's driver has not returned for {} s; expected a driver "
                      "that answers",
                      config_.most_driver_ms / 1000)});
  }
  if (state_.liveness.gpu_lost_ns() > config_.most_gpu_lost_ms * 1'000'000) {
    fail({ErrorCode::kLost,
          fmt::format("the GPU was lost and no picture has been rendered for {} s; expected a GPU that keeps "
                      "working",
                      config_.most_gpu_lost_ms / 1000)});
  }
  end_views(state_.views.second_passed(now_ns()));
  // Before the rest: it frees the memory of sessions that leave.
  for (const auto& session : sessions_.all()) session->second_passed();
  listener_.second_passed();
  if (igtl_) igtl_->second_passed();
  if (archive_) {
    const StillArchive::Report report = archive_->report();
    state_.counters.archive_waiting.set(report.waiting);
    state_.counters.archive_rejections.set(report.refused);
  }
  access_files_.reload(false);
  expire_control();
  rest_api_.second_passed(now_ns());
  audit_.second_passed();
  if (const std::string notice = audit_.take_notice(); !notice.empty()) spdlog::warn("{}", notice);
  dependencies_.counters.audit_lines_lost.set(audit_.lines_lost());
  if (dependencies_.hooks.second_passed) dependencies_.hooks.second_passed(state_.liveness.report());
}

void StreamServer::expire_control() {
  if (!control_.expire(now_ns() / 1'000'000)) return;
  audit_.note({.name = "fanlight"}, {.what = "control", .result = "lapsed"},
              {{"in_control", control_.state().holder.session}});
  sessions_.notify(Notice::kControl);
}

void StreamServer::end_views(const std::vector<ViewAdmission::EndedView>& ended) {
  for (const ViewAdmission::EndedView& view : ended) {
    dependencies_.counters.private_views_ended.add();
    sessions_.view_ended(view.session, view.reason);
  }
}

std::size_t StreamServer::other_clients() const {
  return (igtl_ && igtl_->wants_pictures() ? 1 : 0) + (rtp_ && rtp_->sending() ? 1 : 0);
}

void StreamServer::start_relay() {
  if (!rtp_ || !config_.rtp->at_start) return;
  const auto started = rtp_->start();
  if (!started) spdlog::error("pictures are not sent to {}: {}", rtp_->to(), started.error().message);
  audit_.note({.role = Role::kAdmin, .name = "fanlight"},
              {.what = "rtp", .result = started ? "done" : "failed: " + started.error().message},
              {{"wish", "start"}, {"to", rtp_->to()}, {"by", "configuration"}});
}

StreamServer::~StreamServer() {
  state_.surveys.stop();
  state_.fluid.stop();
  if (igtl_) igtl_->end();  // no one waits for a conversion
  rest_api_.abandon();      // its requests hold connections, which must end before the loop
  for (const auto& session : sessions_.all()) session->abandon();
}

}  // namespace fanlight
