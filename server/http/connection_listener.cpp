// SPDX-License-Identifier: Apache-2.0
#include "server/http/connection_listener.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <new>
#include <utility>

#include "server/net/listen_address.hpp"
#include "server/net/tls_warnings.hpp"

namespace fanlight {

namespace asio = boost::asio;
using asio::ip::tcp;

ConnectionListener::ConnectionListener(asio::io_context& loop, Config config,
                                       const Dependencies& dependencies)
    : config_(std::move(config)), dependencies_(dependencies), acceptor_(loop), pause_(loop) {}

Result<void> ConnectionListener::open() {
  if (!config_.tls.empty()) {
    if (auto read = read_certificates(); !read) return read;
  }
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

Result<void> ConnectionListener::read_certificates() {
  const auto versions = file_marks(config_.tls);
  auto context = make_tls_context(config_.tls);
  if (!context) return context.error();
  certificates_read_ = versions;
  context_ = std::move(*context);
  dependencies_.counters.certificate_expires_timestamp_seconds.set(
      certificate_expires_s(config_.tls.certificate));
  for (const std::string& warning : tls_warnings(config_.tls)) spdlog::warn("{}", warning);
  return {};
}

std::optional<std::string> ConnectionListener::reload_certificates(bool in_any_case) {
  if (config_.tls.empty() || (!in_any_case && file_marks(config_.tls) == certificates_read_)) return {};
  // Files that cannot be read are tried again every second; the same error is reported once.
  const auto read = read_certificates();
  std::string result = read ? "done" : read.error().message;
  if (std::exchange(certificates_result_, read ? "" : result) == result && !in_any_case) return {};
  return result;
}

void ConnectionListener::start() {
  if (chain_.broken() && acceptor_.is_open() && !waits_for_second_) accept();
}

void ConnectionListener::close() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
}

void ConnectionListener::second_passed() {
  rate_.refill();
  if (std::exchange(waits_for_second_, false)) accept();
}

void ConnectionListener::accept() {
  acceptor_.async_accept([this, link = chain_.link()](boost::system::error_code failure, tcp::socket socket) {
    if (failure != asio::error::operation_aborted) accepted(failure, std::move(socket));
  });
}

void ConnectionListener::accepted(boost::system::error_code failure, tcp::socket socket) {
  if (failure) {
    // Probably there is no free file descriptor: wait until a connection may have ended.
    dependencies_.counters.connections_refused.add();
    return accept_later();
  }
  try {
    begin_session(std::move(socket));
  } catch (const std::bad_alloc&) {
    dependencies_.counters.connections_refused.add();  // unwinding has closed the socket
  } catch (const boost::system::system_error&) {
    dependencies_.counters.connections_refused.add();  // OpenSSL found no memory for it
  }
  if (context_ != nullptr && !rate_.may_accept()) {
    waits_for_second_ = true;
  } else {
    accept();
  }
}

void ConnectionListener::accept_later() {
  pause_.expires_after(std::chrono::milliseconds(100));
  pause_.async_wait([this, link = chain_.link()](boost::system::error_code stopped) {
    if (!stopped) accept();
  });
}

void ConnectionListener::begin_session(tcp::socket socket) {
  boost::system::error_code ignored;
  const auto address = socket.remote_endpoint(ignored).address();
  const bool in_time = context_ == nullptr || rate_.take(ConnectionLimit::host_of(address));
  auto permit = in_time ? dependencies_.limit.take(address) : std::nullopt;
  dependencies_.counters.connections_evicted.set(dependencies_.limit.evicted());
  if (!permit) {
    dependencies_.counters.connections_refused.add();  // the destructor closes the socket
    return;
  }
  socket.set_option(tcp::no_delay(true), ignored);
  auto connection =
      context_ != nullptr ? Connection(std::move(socket), context_) : Connection(std::move(socket));
  std::make_shared<HttpSession>(std::move(connection), std::move(*permit), dependencies_.http)->start();
}

}  // namespace fanlight
