#include "server/stream_server.hpp"

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

#include "proto/clock.hpp"
#include "server/http_session.hpp"
#include "server/listen_address.hpp"
#include "server/stream_session.hpp"

namespace fanlight {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

/// How many connections the kernel's limit on descriptors leaves room for, which is raised as far as it may
/// be: without one to spare, no file could be read again.
std::size_t descriptors_for(std::size_t connections) {
  constexpr rlim_t kOthers = 64;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return connections;
  limit.rlim_cur = std::max(limit.rlim_cur, std::min<rlim_t>(limit.rlim_max, connections + kOthers));
  setrlimit(RLIMIT_NOFILE, &limit);
  getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur > kOthers ? limit.rlim_cur - kOthers : 1;
}

}  // namespace

StreamServer::StreamServer(const Config& config, const Dependencies& dependencies, AuditLog audit,
                           AccessDesk access)
    : config_(config),
      from_(dependencies),
      desk_(config.initial_scene, config.suggested_scene, dependencies.scenes),
      probe_(dependencies.probe, config.probe_control),
      views_({.views = dependencies.private_views,
              .bell = dependencies.bell,
              .desk = desk_,
              .render = dependencies.house.render,
              .counters = dependencies.counters},
             config.most_private_views, config.facts.picture_width, config.facts.picture_height),
      hub_(dependencies.counters),
      audit_(std::move(audit)),
      access_(std::move(access)),
      control_(config.control_lapse_ms),
      context_{config_.facts,
               from_.house,
               from_.source_state,
               from_.counters,
               config.endpoint.address().is_loopback(),
               desk_,
               probe_,
               views_,
               hub_,
               access_,
               control_,
               audit_,
               strangers_,
               sessions_so_far_},
      places_(config.most_connections, config.most_connections_a_host) {
  access_.audit_to(audit_);
  // What a display says wrongly is answered and counted here; the library would write a line for each.
  google::protobuf::SetLogHandler(nullptr);
}

Result<std::unique_ptr<StreamServer>> StreamServer::create(const Config& wanted,
                                                           const Dependencies& dependencies) {
  Config config = wanted;
  config.most_connections = std::min(config.most_connections, descriptors_for(config.most_connections));
  AuditLog audit;
  if (!config.audit_log.empty()) {
    auto opened = AuditLog::open(config.audit_log);
    if (!opened) return opened.error();
    audit = std::move(*opened);
  }
  auto access = AccessDesk::create(config.credentials);
  if (!access) return access.error();
  std::unique_ptr<StreamServer> made(
      new StreamServer(config, dependencies, std::move(audit), std::move(*access)));
  if (!config.tls.empty()) {
    if (auto read = made->read_certificates(); !read) return read.error();
  }
  if (auto listening = made->listen(); !listening) return listening.error();
  // The descriptor closes what it watches, and the bell is not ours.
  made->bell_.assign(dup(dependencies.bell.file_descriptor()));
  return made;
}

Result<void> StreamServer::read_certificates() {
  const auto marks = file_marks(config_.tls);
  auto context = make_tls_context(config_.tls);
  if (!context) return context.error();
  certificates_read_ = marks;
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
  bell_rang();  // what was left before the watch began
  count_seconds();
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
    // Out of descriptors, most likely: give those who have one time to leave.
    from_.counters.connections_refused.add();
    accept_pause_.expires_after(std::chrono::milliseconds(100));
    accept_pause_.async_wait([this](boost::system::error_code stopped) {
      if (!stopped) accept();
    });
    return;
  }
  boost::system::error_code ignored;
  if (auto place = places_.take(socket.remote_endpoint(ignored).address())) {
    socket.set_option(tcp::no_delay(true), ignored);
    auto connection = tls_ != nullptr ? Connection(std::move(socket), tls_) : Connection(std::move(socket));
    std::make_shared<HttpSession>(std::move(connection), std::move(*place), context_)->start();
  } else {
    from_.counters.connections_refused.add();  // and closed, as the socket goes
  }
  accept();
}

void StreamServer::watch_bell() {
  bell_.async_wait(asio::posix::descriptor_base::wait_read, [this](boost::system::error_code failure) {
    if (failure) return;
    from_.bell.wait(0);
    bell_rang();
    watch_bell();
  });
}

void StreamServer::bell_rang() {
  if (const Error* broken = from_.failures.newest()) return fail(*broken);
  if (probe_.update()) probe_told();
  if (const Picture* picture = from_.pictures.newest()) {
    views_.main_shown(picture->stamp);
    hub_.show(*picture);
  }
  show_private_views();
}

void StreamServer::show_private_views() {
  for (const Picture* picture : views_.newest(now_ns())) hub_.show(*picture);
  if (!views_.has_more()) return;
  private_pause_.expires_after(std::chrono::nanoseconds(ViewDesk::kBetweenPicturesNs));
  private_pause_.async_wait([this](boost::system::error_code stopped) {
    if (!stopped) show_private_views();
  });
}

void StreamServer::probe_told() {
  const ProbeStatus& status = probe_.status();
  if (status.state != logged_.state || status.trouble != logged_.trouble ||
      status.settings != logged_.settings) {
    logged_ = status;
    spdlog::info("{}{}", probe_.sentence(), status.trouble.empty() ? "" : ": " + status.trouble);
  }
  const double half_rad = radians(status.settings.sweep_deg / 2);
  const bool known = status.geometry.columns > 0;
  const bool other = known && desk_.suggest(scene_for(status.geometry, -half_rad, half_rad));
  for (StreamSession* session : hub_.sessions()) session->probe_changed();
  if (other) tell_of_scene(context_, 0);
}

void StreamServer::count_seconds() {
  second_.expires_after(std::chrono::seconds(1));
  second_.async_wait([this](boost::system::error_code failure) {
    if (failure) return;
    second_passed();
    count_seconds();
  });
}

void StreamServer::second_passed() {
  std::string trouble;
  if (access_.reload(trouble)) {
    audit_.note({.name = "fanlight"},
                {.what = "credentials_read", .result = trouble.empty() ? "done" : trouble});
    if (trouble.empty()) {
      spdlog::info("read the credentials again");
    } else {
      spdlog::error("the credentials stay as they were: {}", trouble);
    }
  }
  if (!config_.tls.empty() && file_marks(config_.tls) != certificates_read_) {
    // What cannot be read is tried again, and told of once.
    const auto read = read_certificates();
    const std::string result = read ? "done" : read.error().message;
    if (std::exchange(certificates_result_, read ? "" : result) != result) {
      audit_.note({.name = "fanlight"}, {.what = "certificates_read", .result = result});
      spdlog::info("the certificates were read again: {}", result);
    }
  }
  if (control_.lapse(now_ns() / 1'000'000)) {
    audit_.note({.name = "fanlight"}, {.what = "control", .result = "lapsed"},
                {{"in_control", control_.state().holder.session}});
    tell_of_control(context_);
  }
  audit_.second_passed();
  from_.counters.audit_lines_lost.set(audit_.lines_lost());
  const auto ended = views_.second_passed();
  // Some of them may leave.
  for (const auto& session : all_sessions()) {
    if (std::ranges::find(ended, session->id()) != ended.end()) {
      from_.counters.private_views_ended.add();
      hub_.forget_view(*session);
      session->view_changed("the main view left it no time for 5 s");
    }
    session->second_passed();
  }
}

std::vector<std::shared_ptr<StreamSession>> StreamServer::all_sessions() const {
  std::vector<std::shared_ptr<StreamSession>> sessions;
  for (const auto* some : {&hub_.sessions(), &strangers_}) {
    for (StreamSession* session : *some) sessions.push_back(session->shared_from_this());
  }
  return sessions;
}

StreamServer::~StreamServer() {
  for (const auto& session : all_sessions()) session->abandon();
}

void tell_of_scene(const StreamContext& context, std::uint64_t but_session) {
  for (StreamSession* session : context.hub.sessions()) {
    if (session->id() != but_session) session->scene_changed();
  }
  const auto changed = context.views.main_changed();
  for (StreamSession* session : context.hub.sessions()) {
    if (std::ranges::find(changed, session->id()) != changed.end()) session->view_changed();
  }
}

void tell_of_control(const StreamContext& context) {
  for (StreamSession* session : context.hub.sessions()) session->control_changed();
}

}  // namespace fanlight
