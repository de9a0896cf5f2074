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

#include "proto/fanlight.pb.h"
#include "proto/result.hpp"

namespace fanlight {

/// A display's end of a stream: says one thing at a time and waits for it. One thread.
class StreamClient {
 public:
  struct Config {
    std::string url = "http://127.0.0.1:8080/";
    std::string token;
    std::filesystem::path server_ca;    ///< who signs the server's certificate; empty: whom the system trusts
    std::filesystem::path certificate;  ///< our own, where it takes the place of a token
    std::filesystem::path key;
    std::string name;  ///< as others are to see us
  };

  /// Connects, shows the token, and takes the Hello. Errors: kUnavailable with what failed; kInvalidArgument:
  /// a login that is refused, a URL that is none.
  static Result<std::unique_ptr<StreamClient>> connect(const Config& config);

  const v1::Hello& hello() const { return hello_; }

  /// The next message, waiting for it. Error: kStopped where the server has closed, with its reason.
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
