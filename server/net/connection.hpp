// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <boost/container/static_vector.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "server/access/digest.hpp"

namespace fanlight {

/// A TCP connection with or without TLS, as one type of stream for HTTP and WebSocket (Beast's concept
/// AsyncStream), for either end. One thread: that of its socket's executor.
class Connection {
 public:
  using next_layer_type = boost::beast::basic_stream<boost::asio::ip::tcp, boost::asio::any_io_executor,
                                                     boost::beast::simple_rate_policy>;
  using executor_type = next_layer_type::executor_type;

  explicit Connection(boost::asio::ip::tcp::socket socket) : stream_(next_layer_type(std::move(socket))) {}
  Connection(boost::asio::ip::tcp::socket socket, std::shared_ptr<boost::asio::ssl::context> context)
      : context_(std::move(context)), stream_(Tls(next_layer_type(std::move(socket)), *context_)) {}

  /// Most bytes that are read from the socket in a second; the rest waits there. Counts all that arrives:
  /// headers, control frames, fragments, TLS.
  void limit_reads(std::size_t bytes_a_second) { next_layer().rate_policy().read_limit(bytes_a_second); }

  bool is_tls() const { return context_ != nullptr; }

  using Done = std::function<void(boost::beast::error_code)>;

  /// `end`: server or client. Precondition: is_tls().
  void async_handshake(boost::asio::ssl::stream_base::handshake_type end, Done done);

  /// For a client, before the handshake: tells the server which host is meant (SNI), and accepts no
  /// certificate that was made for another one. Precondition: is_tls().
  void expect_host(const std::string& host);

  /// Fingerprint of the certificate that the client sent. It was verified: signed by --client-ca and not
  /// expired.
  std::optional<Digest> client_fingerprint();

  /// Why the certificate that the client sent was not accepted; empty if it was, or if the client sent none.
  std::string certificate_trouble();

  // Required by the stream concepts of Beast and Asio.
  executor_type get_executor() { return next_layer().get_executor(); }
  next_layer_type& next_layer() {
    return is_tls() ? std::get<Tls>(stream_).next_layer() : std::get<next_layer_type>(stream_);
  }
  const next_layer_type& next_layer() const { return const_cast<Connection*>(this)->next_layer(); }

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    read_some(gathered<MutableBuffers>(buffers), erased(std::forward<Handler>(handler)));
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    write_some(gathered<ConstBuffers>(buffers), erased(std::forward<Handler>(handler)));
  }

  /// Sends the shutdown of TLS or TCP and closes.
  void async_shutdown(Done done);

  template <typename Handler>
  friend void async_teardown(boost::beast::role_type role, Connection& connection, Handler&& handler) {
    connection.tear_down(role, [kept = kept_for_copies(std::forward<Handler>(handler))](
                                   boost::beast::error_code failure) { (*kept)(failure); });
  }

 private:
  using Tls = boost::beast::ssl_stream<next_layer_type>;
  // Buffers and handlers are converted to one type each. Otherwise the compiler instantiates every operation
  // of HTTP and WebSocket down to the socket, with and without TLS, which took minutes and gigabytes.
  using MutableBuffers = boost::container::static_vector<boost::asio::mutable_buffer, 8>;
  using ConstBuffers = boost::container::static_vector<boost::asio::const_buffer, 8>;
  using Moved = std::function<void(boost::beast::error_code, std::size_t)>;

  /// The first buffers, as many as there is room for: a stream may transfer fewer bytes than offered.
  template <typename To, typename From>
  static To gathered(const From& buffers) {
    To to;
    for (auto buffer = boost::asio::buffer_sequence_begin(buffers);
         buffer != boost::asio::buffer_sequence_end(buffers) && to.size() < to.capacity(); ++buffer) {
      if ((*buffer).size() > 0) to.push_back(*buffer);  // Beast's iterators have no ->
    }
    return to;
  }

  // Beast's handlers are move-only, but a std::function must be copyable.
  template <typename Handler>
  static auto kept_for_copies(Handler&& handler) {
    return std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
  }
  template <typename Handler>
  static Moved erased(Handler&& handler) {
    return [kept = kept_for_copies(std::forward<Handler>(handler))](
               boost::beast::error_code failure, std::size_t bytes) { (*kept)(failure, bytes); };
  }

  void read_some(const MutableBuffers& buffers, Moved moved);
  void write_some(const ConstBuffers& buffers, Moved moved);
  void tear_down(boost::beast::role_type role, Done done);

  std::shared_ptr<boost::asio::ssl::context> context_;  // outlives the stream
  std::variant<next_layer_type, Tls> stream_;
};

}  // namespace fanlight
