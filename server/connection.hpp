#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "server/digest.hpp"

namespace fanlight {

/// A TCP connection, with TLS or without, as one kind of stream for HTTP and WebSocket alike (an AsyncStream
/// in Beast's terms). Server thread only.
class Connection {
 public:
  using next_layer_type = boost::beast::tcp_stream;
  using executor_type = next_layer_type::executor_type;

  explicit Connection(boost::asio::ip::tcp::socket socket) : stream_(next_layer_type(std::move(socket))) {}
  Connection(boost::asio::ip::tcp::socket socket, std::shared_ptr<boost::asio::ssl::context> context)
      : context_(std::move(context)), stream_(Tls(next_layer_type(std::move(socket)), *context_)) {}

  bool is_tls() const { return context_ != nullptr; }

  /// Precondition: is_tls().
  template <typename Handler>
  void async_handshake(Handler&& handler) {
    std::get<Tls>(stream_).async_handshake(boost::asio::ssl::stream_base::server,
                                           std::forward<Handler>(handler));
  }

  /// Of the certificate that the client showed and that was found to be signed and in time.
  std::optional<Digest> client_fingerprint();

  /// What was wrong with the certificate that the client showed; empty where nothing was, or none was shown.
  std::string certificate_trouble();

  // What Beast and Asio ask of a stream.
  executor_type get_executor() { return next_layer().get_executor(); }
  next_layer_type& next_layer() {
    return is_tls() ? std::get<Tls>(stream_).next_layer() : std::get<next_layer_type>(stream_);
  }
  const next_layer_type& next_layer() const { return const_cast<Connection*>(this)->next_layer(); }

  template <typename Buffers, typename Handler>
  auto async_read_some(const Buffers& buffers, Handler&& handler) {
    return is_tls() ? std::get<Tls>(stream_).async_read_some(buffers, std::forward<Handler>(handler))
                    : next_layer().async_read_some(buffers, std::forward<Handler>(handler));
  }
  template <typename Buffers, typename Handler>
  auto async_write_some(const Buffers& buffers, Handler&& handler) {
    return is_tls() ? std::get<Tls>(stream_).async_write_some(buffers, std::forward<Handler>(handler))
                    : next_layer().async_write_some(buffers, std::forward<Handler>(handler));
  }

  /// Says good-bye and closes.
  template <typename Handler>
  void async_shutdown(Handler&& handler) {
    if (is_tls()) return std::get<Tls>(stream_).async_shutdown(std::forward<Handler>(handler));
    boost::beast::error_code failure;
    next_layer().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, failure);
    handler(failure);
  }

  template <typename Handler>
  friend void async_teardown(boost::beast::role_type role, Connection& connection, Handler&& handler) {
    using boost::beast::websocket::async_teardown;
    if (connection.is_tls()) {
      async_teardown(role, std::get<Tls>(connection.stream_), std::forward<Handler>(handler));
    } else {
      async_teardown(role, connection.next_layer().socket(), std::forward<Handler>(handler));
    }
  }

 private:
  using Tls = boost::beast::ssl_stream<next_layer_type>;

  std::shared_ptr<boost::asio::ssl::context> context_;  // outlives the stream
  std::variant<next_layer_type, Tls> stream_;
};

}  // namespace fanlight
