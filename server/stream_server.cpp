#include "server/stream_server.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <csignal>

#include "server/http_session.hpp"
#include "server/listen_address.hpp"
#include "server/stream_session.hpp"

namespace fanlight {

namespace asio = boost::asio;
using asio::ip::tcp;

StreamServer::StreamServer(const Config& config, const Dependencies& dependencies)
    : config_(config),
      from_(dependencies),
      desk_(config.initial_scene, config.suggested_scene, dependencies.scenes),
      probe_(dependencies.probe, config.probe_control),
      hub_({.jpeg_quality = config.jpeg_quality}, dependencies.counters),
      context_{config_.facts,
               from_.house,
               from_.source_state,
               from_.counters,
               config.endpoint.address().is_loopback(),
               desk_,
               probe_,
               hub_} {}

Result<std::unique_ptr<StreamServer>> StreamServer::create(const Config& config,
                                                           const Dependencies& dependencies) {
  std::unique_ptr<StreamServer> made(new StreamServer(config, dependencies));
  if (auto listening = made->listen(); !listening) return listening.error();
  // The descriptor closes what it watches, and the bell is not ours.
  made->bell_.assign(dup(dependencies.bell.file_descriptor()));
  return made;
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
                    page_url(config_.endpoint), failure.message())};
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
  if (connections_ < config_.most_connections) {
    boost::system::error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    std::make_shared<HttpSession>(std::move(socket), ConnectionPlace(connections_), context_)->read();
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
    if (auto shown = hub_.show(*picture); !shown) fail(shown.error());
  }
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
  for (StreamSession* session : hub_.sessions()) {
    session->probe_changed();
    if (other) session->scene_changed();
  }
}

void StreamServer::count_seconds() {
  second_.expires_after(std::chrono::seconds(1));
  second_.async_wait([this](boost::system::error_code failure) {
    if (failure) return;
    for (StreamSession* session : hub_.sessions()) session->statistics_due();
    count_seconds();
  });
}

}  // namespace fanlight
