// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"
#include "server/net/connection.hpp"

namespace fanlight {

/// A blocking client of the stream, for one thread.
class StreamClient {
 public:
  struct Config {
    std::string url = "http://127.0.0.1:8080/";
    std::string token;
    std::filesystem::path server_ca;    ///< authority of the server's certificate; empty: those of the system
    std::filesystem::path certificate;  ///< of the client, instead of a token
    std::filesystem::path key;
    std::string name;  ///< of this client, for other clients to see
  };

  /// Connects, logs in, and waits for the Hello, ten seconds for each step at most, but for finding the name.
  /// Errors: kUnavailable with the step that failed, or why the login was refused; kInvalidArgument: the URL
  /// is none.
  static Result<std::unique_ptr<StreamClient>> connect(const Config& config);

  const v1::Hello& hello() const { return hello_; }

  /// Waits for the next message. Error, kStopped: the server has closed the connection, with its reason.
  Result<v1::ServerMessage> next();
  /// The same, but gives up after a time: empty if no message came. The server sends one a second at least,
  /// so a silence of two seconds means that it, or the way to it, has stopped.
  Result<std::optional<v1::ServerMessage>> next_within(std::chrono::milliseconds time);
  Result<void> send(const v1::ClientMessage& message);

 private:
  /// Without compression of messages, which no Fanlight offers: half of what the compiler would instantiate.
  using WebSocket = boost::beast::websocket::stream<Connection, false>;

  StreamClient() = default;
  Result<void> open(const Config& config);
  Result<void> greet(const Config& config);
  boost::system::error_code connect_to(const boost::asio::ip::tcp::resolver::results_type& endpoints);
  /// Starts an operation with a handler, and waits for its end.
  template <typename Start>
  boost::system::error_code finish(Start start);

  boost::asio::io_context loop_;
  std::optional<WebSocket> socket_;
  // Of the read under way, which next_within() may leave behind.
  boost::beast::flat_buffer incoming_;
  std::optional<boost::system::error_code> read_;  // its result; empty while it is under way
  bool reading_ = false;
  v1::Hello hello_;
};

}  // namespace fanlight
