// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"

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

  /// Connects, logs in, and waits for the Hello. Errors: kUnavailable with the step that failed;
  /// kInvalidArgument: the login was refused, or the URL is invalid.
  static Result<std::unique_ptr<StreamClient>> connect(const Config& config);

  const v1::Hello& hello() const { return hello_; }

  /// Waits for the next message. Error, kStopped: the server has closed the connection, with its reason.
  Result<v1::ServerMessage> next();
  Result<void> send(const v1::ClientMessage& message);

 private:
  using Plain = boost::beast::websocket::stream<boost::beast::tcp_stream>;
  using Tls = boost::beast::websocket::stream<boost::beast::ssl_stream<boost::beast::tcp_stream>>;

  StreamClient() = default;
  Result<void> open(const Config& config);
  Result<void> greet(const Config& config);

  boost::asio::io_context loop_;
  std::unique_ptr<boost::asio::ssl::context> context_;
  std::variant<std::monostate, Plain, Tls> socket_;
  v1::Hello hello_;
};

}  // namespace fanlight
