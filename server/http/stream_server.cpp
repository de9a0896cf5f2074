// SPDX-License-Identifier: Apache-2.0
#include "server/http/stream_server.hpp"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "server/state/path_privacy.hpp"

namespace fanlight {

namespace asio = boost::asio;

namespace {

// Fewer connections than this are too few for a ward: the administrator is told.
constexpr std::size_t kFewConnections = 256;

}  // namespace

StreamServer::StreamServer(const Config& config, const Dependencies& dependencies, AuditLog audit,
                           Authenticator access)
    : config_(config),
      dependencies_(dependencies),
      scene_store_(config.initial_scene, config.suggested_scene, dependencies.scenes, config.chosen_fields),
      probe_(dependencies.probe, config.probe_control),
      liveness_(dependencies_.pipeline, now_ns()),
      views_({.views = dependencies.private_views,
              .ends = dependencies.private_view_ends,
              .bell = dependencies.bell,
              .scene_store = scene_store_,
              .render = dependencies.pipeline.render,
              .counters = dependencies.counters},
             config.most_private_views, config.facts.picture_width, config.facts.picture_height),
      surveys_(dependencies.survey_orders, dependencies.survey_results),
      recording_(config.recording, dependencies.recording, utc_now_s),
      replay_(dependencies.replay, config.facts.path),
      cine_(dependencies.cine),
      demand_(dependencies.audience),
      default_view_(config.finds_view, scene_store_, surveys_, config_.facts.notes),
      hub_(dependencies.counters, hub_config()),
      sessions_(views_),
      audit_(std::move(audit)),
      access_(std::move(access)),
      control_(config.control_lapse_ms),
      messages_({.description = config_.facts,
                 .pipeline = dependencies_.pipeline,
                 .source_state = dependencies_.source_state,
                 .scene_store = scene_store_,
                 .probe = probe_,
                 .liveness = liveness_,
                 .recording = recording_,
                 .replay = replay_,
                 .cine = cine_,
                 .presets = presets_,
                 .relayed = relayed_,
                 .views = views_,
                 .control = control_,
                 .hub = hub_}),
      request_dependencies_{.counters = dependencies_.counters,
                            .scene_store = scene_store_,
                            .probe = probe_,
                            .views = views_,
                            .surveys = surveys_,
                            .recording = recording_,
                            .replay = replay_,
                            .cine = cine_,
                            .presets = presets_,
                            .hub = hub_,
                            .access = access_,
                            .control = control_,
                            .sessions = sessions_,
                            .messages = messages_,
                            .jpeg_quality = config_.facts.jpeg_quality},
      stream_dependencies_{.counters = dependencies_.counters,
                           .probe = probe_,
                           .recording = recording_,
                           .views = views_,
                           .hub = hub_,
                           .access = access_,
                           .control = control_,
                           .audit = audit_,
                           .sessions = sessions_,
                           .messages = messages_,
                           .requests = request_dependencies_,
                           .limits = config.session_limits},
      rtp_api_({.counters = dependencies_.counters, .audit = audit_, .sender = rtp_}),
      rest_api_({.counters = dependencies_.counters,
                 .scene_store = scene_store_,
                 .hub = hub_,
                 .control = control_,
                 .audit = audit_,
                 .sessions = sessions_,
                 .recording = recording_,
                 .replay = replay_,
                 .cine = cine_,
                 .presets = presets_,
                 .demand = demand_,
                 .rtp = rtp_api_}),
      http_dependencies_{.counters = dependencies_.counters,
                         .audit = audit_,
                         .access = access_,
                         .probe = probe_,
                         .source_state = dependencies_.source_state,
                         .liveness = liveness_,
                         .hsts = config.hsts,
                         .loopback_only = config.endpoint.address().is_loopback(),
                         .rest_api = rest_api_,
                         .demand = demand_,
                         .metrics = {.pipeline = dependencies_.pipeline,
                                     .counters = dependencies_.counters,
                                     .probe = probe_,
                                     .liveness = liveness_,
                                     .times = times_,
                                     .recording = recording_,
                                     .replay = replay_,
                                     .hub = hub_,
                                     .scene_store = scene_store_},
                         .stream = stream_dependencies_},
      connection_limit_(config.most_connections, config.most_connections_a_host),
      listener_(loop_, {.endpoint = config.endpoint, .tls = config.tls},
                {.counters = dependencies_.counters, .limit = connection_limit_, .http = http_dependencies_}),
      signals_(loop_, {.end = [this] { end("the server ends"); },
                       .end_now = [this] { stop(); },
                       .read_again = [this] { read_again(); },
                       .tell_state = [this] { tell_state(); }}) {
  if (config.igtl) igtl_.emplace(loop_, *config.igtl, igtl_dependencies());
  if (config.rtp) rtp_.emplace(loop_, *config.rtp, rtp_dependencies());
  access_.audit_to(audit_);
  sessions_.when_opened([this] { liveness_watch_.update(); });
  dependencies_.source_state = [this, of_thread = dependencies.source_state] {
    if (replay_.status().state == ReplayStatus::State::kEnded) return std::string("ended");
    return without_path(of_thread(), config_.facts.path, "the recording");
  };
  // The library would log a line for each malformed message; the sessions answer and count them.
  google::protobuf::SetLogHandler(nullptr);
}

PictureHub::Config StreamServer::hub_config() {
  PictureHub::Config config;
  config.executor = [this](EncoderLane lane, std::function<void()> work, std::function<void()> done) {
    // Shared, so that nothing is lost where it cannot be handed over at once.
    const auto kept = std::make_shared<std::function<void()>>(std::move(done));
    encoders_.submit(lane, [this, work = std::move(work), kept] {
      work();
      post(kept);
    });
  };
  config.threads = EncoderPool::usual_threads();
  return config;
}

void StreamServer::post(const std::shared_ptr<std::function<void()>>& done) {
  while (!loop_.stopped()) {
    try {
      return asio::post(loop_, [done] { (*done)(); });
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
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
  }
  auto access = Authenticator::create(config.credentials);
  if (!access) return access.error();
  std::unique_ptr<StreamServer> server(
      new StreamServer(config, dependencies, std::move(audit), std::move(*access)));
  server->load_presets();
  if (auto listening = server->listener_.open(); !listening) return listening.error();
  if (server->igtl_) {
    if (auto listening = server->igtl_->open(); !listening) return listening.error();
  }
  // The stream descriptor closes its file descriptor, which belongs to the bell: so it gets a duplicate.
  server->bell_.assign(dup(dependencies.bell.file_descriptor()));
  return server;
}

Result<void> StreamServer::run() {
  const double session_mb = static_cast<double>(SessionLimits::most_bytes(config_.facts.picture_width,
                                                                          config_.facts.picture_height)) /
                            1e6;
  spdlog::info("a display takes up to {:.1f} MB of memory; {} connections at most", session_mb,
               config_.most_connections);
  signals_.start();
  bell_rang();  // values may have come before
  start_rtp();
  run_loop();
  signals_.release_ends();
  if (presets_unwritten_) save_presets(presets_.json());
  close_audit();
  if (failure_) return *failure_;
  return {};
}

void StreamServer::run_loop() {
  for (;;) {
    try {
      begin_chains();
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

void StreamServer::begin_chains() {
  if (!ending_) listener_.start();
  if (!ending_ && igtl_) igtl_->start();
  if (!ending_ && rtp_) rtp_->keep_alive();
  if (bell_chain_.broken()) watch_bell();
  if (second_chain_.broken()) start_second();
  liveness_watch_.start();
  signals_.start();
  if (ending_ && end_chain_.broken()) stop_without_sessions();
}

void StreamServer::fail(const Error& error) {
  if (!failure_) failure_ = error;
  end("the server ends after a failure");
}

void StreamServer::end(const std::string& reason) {
  if (std::exchange(ending_, true)) return;
  listener_.close();
  if (dependencies_.ends) dependencies_.ends();
  end_until_ns_ = now_ns() + config_.most_end_ms * 1'000'000;
  for (const auto& session : sessions_.all()) session->end(reason);
  if (igtl_) igtl_->end();
  if (rtp_) rtp_->stop();
  stop_without_sessions();
}

void StreamServer::stop_without_sessions() {
  const bool all_left = sessions_.all().empty() && (!igtl_ || igtl_->clients() == 0);
  if (now_ns() >= end_until_ns_ || all_left) return stop();
  end_pause_.expires_after(std::chrono::milliseconds(10));
  end_pause_.async_wait([this, link = end_chain_.link()](boost::system::error_code stopped) {
    if (!stopped) stop_without_sessions();
  });
}

void StreamServer::close_audit() {
  for (const auto& session : sessions_.all()) session->abandon();
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
  if (dependencies_.read_again && !dependencies_.read_again()) {
    spdlog::info("SIGHUP: the terminal that started the server was closed, so the server ends");
    return end("the server ends");
  }
  spdlog::info(
      "SIGHUP: reads configuration, tokens and certificates again, and looks whether the audit log was "
      "moved");
  reload_credentials(true);
  reload_certificates(true);
  audit_.reopen();
  if (dependencies_.was_read_again) dependencies_.was_read_again();
}

void StreamServer::tell_state() {
  const ControlLease::Party& holder = control_.state().holder;
  const AuditPosition newest = audit_.newest();
  const std::string audit =
      newest.line == 0 ? ""
                       : fmt::format(", line {} of the audit log has the hash {}", newest.line, newest.hash);
  spdlog::info("SIGUSR1: {} sessions, in control: {}, source {}{}", sessions_.all().size(),
               holder.session == 0 ? "nobody" : holder.name, dependencies_.source_state(), audit);
}

void StreamServer::watch_bell() {
  bell_.async_wait(asio::posix::descriptor_base::wait_read,
                   [this, link = bell_chain_.link()](boost::system::error_code failure) {
                     if (failure) return;
                     dependencies_.bell.wait(0);
                     bell_rang();
                     watch_bell();
                   });
}

void StreamServer::bell_rang() {
  if (const Error* broken = dependencies_.failures.newest()) return fail(*broken);
  if (probe_.update()) probe_changed();
  recording_watch_.update();
  if (replay_.update()) tell_of_replay();
  if (cine_.update()) sessions_.cine_changed();
  if (igtl_) igtl_->bell_rang();
  if (const Picture* picture = dependencies_.pictures.newest()) {
    views_.main_shown(picture->stamp, now_ns());
    liveness_.shown(picture->stamp, now_ns());
    times_.shown(picture->stamp);
    recording_.picture_shown(picture->stamp, picture->width, picture->height, scene_store_);
    demand_.picture_shown(now_ns());
    if (!demand_.resting()) hub_.show(*picture);
    if (igtl_ && !demand_.resting()) igtl_->show(*picture);
    default_view_.picture_shown(picture->stamp, now_ns());
  }
  liveness_watch_.update();
  rest_api_.answer_waiting(now_ns());
  for (const SurveyDesk::Answer& answer : surveys_.answers(scene_store_.in_force().scene)) {
    if (answer.session == SurveyDesk::kServer) {
      if (default_view_.answered(answer)) sessions_.scene_changed(0);
    } else {
      sessions_.survey_answered(answer.session, answer.reply);
    }
  }
  end_views(views_.ended_by_renderer());
  show_private_views();
}

void StreamServer::show_private_views() {
  for (const Picture* picture : views_.newest(now_ns())) hub_.show(*picture);
  if (!views_.has_more()) return;
  private_pause_.expires_after(std::chrono::nanoseconds(ViewAdmission::kBetweenPicturesNs));
  private_pause_.async_wait([this](boost::system::error_code stopped) {
    if (!stopped) show_private_views();
  });
}

void StreamServer::probe_changed() {
  const ProbeStatus& status = probe_.status();
  if (status.state != logged_.state || status.trouble != logged_.trouble ||
      status.settings != logged_.settings) {
    logged_ = status;
    spdlog::info("{}{}", probe_.sentence(), status.trouble.empty() ? "" : ": " + status.trouble);
  }
  const double half_rad = radians(status.settings.sweep_deg / 2);
  const bool has_geometry = status.geometry.columns > 0;
  Scene suggested = scene_for(status.geometry, -half_rad, half_rad);
  suggested.deadline = scene_store_.default_scene().deadline;  // by the device, not by the probe
  const bool scene_differs = has_geometry && default_view_.source_changed(suggested, now_ns());
  sessions_.probe_changed();
  if (scene_differs) sessions_.scene_changed(0);
}

void StreamServer::tell_of_replay() {
  const std::string before = std::exchange(replay_trouble_, replay_.message().trouble());
  if (!replay_trouble_.empty() && replay_trouble_ != before) spdlog::warn("{}", replay_trouble_);
  sessions_.replay_changed();
}

StreamServer::~StreamServer() {
  if (igtl_) igtl_->end();  // nobody waits for a conversion
  rest_api_.abandon();      // its requests hold connections, which must end before the loop
  for (const auto& session : sessions_.all()) session->abandon();
}

}  // namespace fanlight
