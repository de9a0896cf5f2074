// SPDX-License-Identifier: Apache-2.0
#include "server/http/stream_server.hpp"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "server/net/listen_address.hpp"

namespace fanlight {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

// Open files besides connections: the GPU's, the source's, the logs.
constexpr rlim_t kOtherFiles = 64;
// Fewer connections than this are too few for a ward: the administrator is told.
constexpr std::size_t kFewConnections = 256;
// How often it is looked at whether the picture is live.
constexpr auto kLivenessInterval = std::chrono::milliseconds(250);

PictureLiveness::Source liveness_source(const std::string& source_state, bool probe_lost) {
  using State = PictureLiveness::Source::State;
  if (source_state == "running") return {.state = State::kRunning, .failure = "", .probe_lost = probe_lost};
  if (source_state == "ended") return {.state = State::kEnded, .failure = "", .probe_lost = probe_lost};
  return {.state = State::kFailed, .failure = source_state, .probe_lost = probe_lost};
}

/// The number of connections, at most `connections`, for which the process has file descriptors. Raises the
/// limit of the process as far as possible, and keeps some descriptors for files.
std::size_t connections_within_limit(std::size_t connections) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return connections;
  limit.rlim_cur = std::max(limit.rlim_cur, std::min<rlim_t>(limit.rlim_max, connections + kOtherFiles));
  setrlimit(RLIMIT_NOFILE, &limit);
  getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur > kOtherFiles ? limit.rlim_cur - kOtherFiles : 1;
}

}  // namespace

StreamServer::StreamServer(const Config& config, const Dependencies& dependencies, AuditLog audit,
                           Authenticator access)
    : config_(config),
      dependencies_(dependencies),
      scene_store_(config.initial_scene, config.suggested_scene, dependencies.scenes),
      probe_(dependencies.probe, config.probe_control),
      liveness_(dependencies_.pipeline, now_ns()),
      views_({.views = dependencies.private_views,
              .bell = dependencies.bell,
              .scene_store = scene_store_,
              .render = dependencies.pipeline.render,
              .counters = dependencies.counters},
             config.most_private_views, config.facts.picture_width, config.facts.picture_height),
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
                 .views = views_,
                 .control = control_,
                 .hub = hub_}),
      request_dependencies_{.counters = dependencies_.counters,
                            .scene_store = scene_store_,
                            .probe = probe_,
                            .views = views_,
                            .hub = hub_,
                            .access = access_,
                            .control = control_,
                            .sessions = sessions_,
                            .messages = messages_,
                            .jpeg_quality = config_.facts.jpeg_quality},
      stream_dependencies_{.counters = dependencies_.counters,
                           .probe = probe_,
                           .views = views_,
                           .hub = hub_,
                           .access = access_,
                           .control = control_,
                           .audit = audit_,
                           .sessions = sessions_,
                           .messages = messages_,
                           .requests = request_dependencies_},
      rest_api_({.counters = dependencies_.counters,
                 .scene_store = scene_store_,
                 .hub = hub_,
                 .control = control_,
                 .audit = audit_,
                 .sessions = sessions_}),
      http_dependencies_{.counters = dependencies_.counters,
                         .audit = audit_,
                         .access = access_,
                         .probe = probe_,
                         .source_state = dependencies_.source_state,
                         .liveness = liveness_,
                         .hsts = config.hsts,
                         .loopback_only = config.endpoint.address().is_loopback(),
                         .rest_api = rest_api_,
                         .metrics = {.pipeline = dependencies_.pipeline,
                                     .counters = dependencies_.counters,
                                     .probe = probe_,
                                     .liveness = liveness_,
                                     .hub = hub_,
                                     .scene_store = scene_store_},
                         .stream = stream_dependencies_},
      connection_limit_(config.most_connections, config.most_connections_a_host) {
  access_.audit_to(audit_);
  // The library would log a line for each malformed message; the sessions answer and count them.
  google::protobuf::SetLogHandler(nullptr);
}

PictureHub::Config StreamServer::hub_config() {
  PictureHub::Config config;
  config.executor = [this](EncoderLane lane, std::function<void()> work, std::function<void()> done) {
    encoders_.submit(lane, [this, work = std::move(work), done = std::move(done)]() mutable {
      work();
      asio::post(loop_, std::move(done));
    });
  };
  config.threads = EncoderPool::usual_threads();
  return config;
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
    auto opened = AuditLog::open(config.audit_log);
    if (!opened) return opened.error();
    audit = std::move(*opened);
  }
  auto access = Authenticator::create(config.credentials);
  if (!access) return access.error();
  std::unique_ptr<StreamServer> server(
      new StreamServer(config, dependencies, std::move(audit), std::move(*access)));
  if (!config.tls.empty()) {
    if (auto read = server->read_certificates(); !read) return read.error();
  }
  if (auto listening = server->listen(); !listening) return listening.error();
  // The stream descriptor closes its file descriptor, which belongs to the bell: so it gets a duplicate.
  server->bell_.assign(dup(dependencies.bell.file_descriptor()));
  return server;
}

Result<void> StreamServer::read_certificates() {
  const auto versions = file_marks(config_.tls);
  auto context = make_tls_context(config_.tls);
  if (!context) return context.error();
  certificates_read_ = versions;
  tls_ = std::move(*context);
  return {};
}

Result<void> StreamServer::listen() {
  boost::system::error_code failure;
  acceptor_.open(config_.endpoint.protocol(), failure);
  if (!failure) acceptor_.set_option(tcp::acceptor::reuse_address(true), failure);
  if (!failure) acceptor_.bind(config_.endpoint, failure);
  if (!failure) acceptor_.listen(asio::socket_base::max_listen_connections, failure);
  if (failure) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("listening on {} failed ({}), expected an address of this machine and a free port",
                    page_url(config_.endpoint, !config_.tls.empty()), failure.message())};
  }
  return {};
}

Result<void> StreamServer::run() {
  boost::system::error_code ignored;
  signals_.add(SIGINT, ignored);
  signals_.add(SIGTERM, ignored);
  signals_.async_wait([this](boost::system::error_code failure, int) {
    if (!failure) stop();
  });
  accept();
  watch_bell();
  bell_rang();  // values may have come before
  start_second();
  start_liveness();
  loop_.run();
  if (audit_.lines() > 0)
    spdlog::info("the audit log has {} lines, the newest with the hash {}", audit_.lines(),
                 audit_.newest_hash());
  if (failure_) return *failure_;
  return {};
}

void StreamServer::fail(const Error& error) {
  failure_ = error;
  stop();
}

void StreamServer::accept() {
  acceptor_.async_accept([this](boost::system::error_code failure, tcp::socket socket) {
    if (failure != asio::error::operation_aborted) accepted(failure, std::move(socket));
  });
}

void StreamServer::accepted(boost::system::error_code failure, tcp::socket socket) {
  if (failure) {
    // Probably there is no free file descriptor: wait until a connection may have ended.
    dependencies_.counters.connections_refused.add();
    accept_pause_.expires_after(std::chrono::milliseconds(100));
    accept_pause_.async_wait([this](boost::system::error_code stopped) {
      if (!stopped) accept();
    });
    return;
  }
  boost::system::error_code ignored;
  const auto address = socket.remote_endpoint(ignored).address();
  const bool in_time = tls_ == nullptr || connect_rate_.take(ConnectionLimit::host_of(address));
  auto permit = in_time ? connection_limit_.take(address) : std::nullopt;
  dependencies_.counters.connections_evicted.set(connection_limit_.evicted());
  if (permit) {
    socket.set_option(tcp::no_delay(true), ignored);
    auto connection = tls_ != nullptr ? Connection(std::move(socket), tls_) : Connection(std::move(socket));
    std::make_shared<HttpSession>(std::move(connection), std::move(*permit), http_dependencies_)->start();
  } else {
    dependencies_.counters.connections_refused.add();  // the destructor closes the socket
  }
  if (tls_ == nullptr || connect_rate_.may_accept()) {
    accept();
  } else {
    accepts_ = false;  // until the second has passed
  }
}

void StreamServer::watch_bell() {
  bell_.async_wait(asio::posix::descriptor_base::wait_read, [this](boost::system::error_code failure) {
    if (failure) return;
    dependencies_.bell.wait(0);
    bell_rang();
    watch_bell();
  });
}

void StreamServer::bell_rang() {
  if (const Error* broken = dependencies_.failures.newest()) return fail(*broken);
  if (probe_.update()) probe_changed();
  if (dependencies_.render_health != nullptr) {
    if (const RenderHealth* health = dependencies_.render_health->newest()) liveness_.health_changed(*health);
  }
  if (const Picture* picture = dependencies_.pictures.newest()) {
    views_.main_shown(picture->stamp, now_ns());
    liveness_.shown(picture->stamp, now_ns());
    hub_.show(*picture);
  }
  update_liveness();
  show_private_views();
}

void StreamServer::start_liveness() {
  liveness_pause_.expires_after(kLivenessInterval);
  liveness_pause_.async_wait([this](boost::system::error_code failure) {
    if (failure) return;
    update_liveness();
    start_liveness();
  });
}

void StreamServer::update_liveness() {
  if (!liveness_.update(liveness_source(dependencies_.source_state(), probe_.lost()), now_ns())) return;
  log_liveness();
  sessions_.liveness_changed();
}

void StreamServer::log_liveness() {
  const PictureLiveness::Report& report = liveness_.report();
  if (report.live() || report.state == PictureLiveness::State::kWaiting) {
    spdlog::info("{}", report.sentence);
  } else {
    spdlog::warn("the picture is {}, {:.1f} s old: {}",
                 report.state == PictureLiveness::State::kDelayed ? "delayed" : "not live", report.age_s,
                 report.sentence);
  }
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
  const bool scene_differs =
      has_geometry && scene_store_.suggest(scene_for(status.geometry, -half_rad, half_rad));
  sessions_.probe_changed();
  if (scene_differs) sessions_.scene_changed(0);
}

void StreamServer::start_second() {
  second_.expires_after(std::chrono::seconds(1));
  second_.async_wait([this](boost::system::error_code failure) {
    if (failure) return;
    second_passed();
    start_second();
  });
}

void StreamServer::second_passed() {
  connect_rate_.refill();
  if (!std::exchange(accepts_, true)) accept();
  reload_credentials();
  reload_certificates();
  lapse_control();
  audit_.second_passed();
  dependencies_.counters.audit_lines_lost.set(audit_.lines_lost());
  notify_sessions_of_second();
}

void StreamServer::reload_credentials() {
  std::string trouble;
  if (!access_.reload(trouble)) return;
  audit_.note({.name = "fanlight"},
              {.what = "credentials_read", .result = trouble.empty() ? "done" : trouble});
  if (trouble.empty()) {
    spdlog::info("read the credentials again");
  } else {
    spdlog::error("the credentials stay as they were: {}", trouble);
  }
}

void StreamServer::reload_certificates() {
  if (config_.tls.empty() || file_marks(config_.tls) == certificates_read_) return;
  // Files that cannot be read are tried again every second; the same error is logged once.
  const auto read = read_certificates();
  const std::string result = read ? "done" : read.error().message;
  if (std::exchange(certificates_result_, read ? "" : result) == result) return;
  audit_.note({.name = "fanlight"}, {.what = "certificates_read", .result = result});
  spdlog::info("the certificates were read again: {}", result);
}

void StreamServer::lapse_control() {
  if (!control_.expire(now_ns() / 1'000'000)) return;
  audit_.note({.name = "fanlight"}, {.what = "control", .result = "lapsed"},
              {{"in_control", control_.state().holder.session}});
  sessions_.control_changed();
}

void StreamServer::notify_sessions_of_second() {
  const auto ended = views_.second_passed(now_ns());
  for (const auto& session : sessions_.all()) {
    const auto view = std::ranges::find(ended, session->id(), &ViewAdmission::EndedView::session);
    if (view != ended.end()) {
      dependencies_.counters.private_views_ended.add();
      session->view_ended(view->reason);
    }
    session->second_passed();
  }
}

StreamServer::~StreamServer() {
  for (const auto& session : sessions_.all()) session->abandon();
}

}  // namespace fanlight
