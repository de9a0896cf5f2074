// SPDX-License-Identifier: Apache-2.0
#include "server/client/stream_client.hpp"

#include <fmt/format.h>
#include <openssl/err.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <utility>

#include "server/client/server_url.hpp"

namespace fanlight {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using asio::ip::tcp;

namespace {

constexpr std::size_t kLargestMessageBytes = 64 << 20;
/// For each step until the server has greeted: it may stand still, or be no server of Fanlight.
constexpr std::chrono::seconds kPatience{10};

Error broken(const std::string& what, const boost::system::error_code& why) {
  return {ErrorCode::kUnavailable, fmt::format("{} failed ({})", what, why.message())};
}

Error silent(const std::string& url) {
  return {ErrorCode::kUnavailable,
          fmt::format("{} has not answered for {} s, expected a server of Fanlight", url, kPatience.count())};
}

Error broken_tls(const std::string& url, const boost::system::error_code& why) {
  if (why.category() == asio::error::get_ssl_category() &&
      ERR_GET_REASON(static_cast<unsigned long>(why.value())) == SSL_R_CERTIFICATE_VERIFY_FAILED) {
    return {ErrorCode::kUnavailable,
            fmt::format(
                "the certificate of {} is not trusted, expected --server-ca FILE with who signed it, and the "
                "name that it was made for",
                url)};
  }
  return broken("TLS with " + url, why);
}

Result<std::shared_ptr<asio::ssl::context>> client_context(const StreamClient::Config& config) {
  auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_client);
  boost::system::error_code failure;
  context->set_verify_mode(asio::ssl::verify_peer);
  if (config.server_ca.empty()) {
    context->set_default_verify_paths(failure);
  } else {
    context->load_verify_file(config.server_ca.string(), failure);
  }
  if (failure) return broken("reading " + config.server_ca.string(), failure);
  if (config.certificate.empty()) return context;
  context->use_certificate_chain_file(config.certificate.string(), failure);
  if (failure) return broken("reading " + config.certificate.string(), failure);
  context->use_private_key_file(config.key.string(), asio::ssl::context::pem, failure);
  if (failure) return broken("reading " + config.key.string(), failure);
  return context;
}

}  // namespace

template <typename Start>
boost::system::error_code StreamClient::finish(Start start) {
  boost::system::error_code result;
  bool done = false;
  start([&](boost::system::error_code failure, const auto&... /*unused*/) {
    result = failure;
    done = true;
  });
  loop_.restart();
  // Timers of a failed operation may be left: they end with the loop.
  while (!done && loop_.run_one() > 0) continue;
  return result;
}

/// Tries the addresses of a host one after the other: the first may drop packets.
boost::system::error_code StreamClient::connect_to(const tcp::resolver::results_type& endpoints) {
  auto& socket = socket_->next_layer().next_layer();
  boost::system::error_code failure = asio::error::host_not_found;
  for (const auto& endpoint : endpoints) {
    socket.expires_after(kPatience);
    failure = finish([&](auto done) { socket.async_connect(endpoint.endpoint(), done); });
    if (!failure) break;
    socket.close();
  }
  return failure;
}

Result<std::unique_ptr<StreamClient>> StreamClient::connect(const Config& config) {
  std::unique_ptr<StreamClient> made(new StreamClient());
  if (auto opened = made->open(config); !opened) return opened.error();
  if (auto greeted = made->greet(config); !greeted) return greeted.error();
  return made;
}

Result<void> StreamClient::open(const Config& config) {
  const auto url = parse_server_url(config.url);
  if (!url) return url.error();
  const std::string server = url->text();
  boost::system::error_code failure;
  tcp::resolver resolver(loop_);
  const auto endpoints = resolver.resolve(url->host, url->port, failure);
  if (failure) return broken("finding " + url->host, failure);
  if (!config.token.empty() && !url->tls && !endpoints.begin()->endpoint().address().is_loopback()) {
    return Error{ErrorCode::kInvalidArgument,
                 "a token would travel in the clear, expected https:// or a loopback address"};
  }
  if (url->tls) {
    auto context = client_context(config);
    if (!context) return context.error();
    socket_.emplace(tcp::socket(loop_), *std::move(context));
    socket_->next_layer().expect_host(url->host);
  } else {
    socket_.emplace(tcp::socket(loop_));
  }
  failure = connect_to(endpoints);
  if (failure) return broken("connecting to " + server, failure);
  Connection& connection = socket_->next_layer();
  if (url->tls) {
    connection.next_layer().expires_after(kPatience);
    failure = finish([&](auto done) { connection.async_handshake(asio::ssl::stream_base::client, done); });
    if (failure) return broken_tls(server, failure);
  }
  connection.next_layer().expires_never();
  const auto decorate = [](websocket::request_type& request) {
    request.set(beast::http::field::sec_websocket_protocol, "fanlight.v2");
  };
  socket_->set_option(websocket::stream_base::decorator(decorate));
  socket_->read_message_max(kLargestMessageBytes);
  socket_->binary(true);
  socket_->set_option(websocket::stream_base::timeout{.handshake_timeout = kPatience,
                                                      .idle_timeout = websocket::stream_base::none(),
                                                      .keep_alive_pings = false});
  websocket::response_type response;
  failure =
      finish([&](auto done) { socket_->async_handshake(response, url->host_and_port(), "/stream", done); });
  // Fanlight says why in one line; other programs answer with pages.
  const bool is_text = std::string_view(response[beast::http::field::content_type]).starts_with("text/plain");
  const std::string answer =
      failure == websocket::error::upgrade_declined && is_text ? response.body() : std::string();
  if (!answer.empty()) return Error{ErrorCode::kUnavailable, answer.substr(0, answer.find('\n'))};
  if (failure == beast::error::timeout) return silent(server);
  if (failure) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("{} did not answer as a server of Fanlight does ({}), expected another address{}", server,
                    failure.message(), url->tls ? "" : ", or https:// where the server has TLS")};
  }
  return {};
}

Result<void> StreamClient::greet(const Config& config) {
  v1::ClientMessage login;
  login.mutable_login()->set_token(config.token);
  login.mutable_login()->set_name(config.name);
  bool login_sent = false;
  for (;;) {
    auto within = next_within(kPatience);
    if (!within) return within.error();
    if (!*within) return silent(config.url);
    const v1::ServerMessage* const message = &**within;
    if (message->has_error()) return Error{ErrorCode::kUnavailable, message->error().message()};
    if (message->has_login_needed() && !std::exchange(login_sent, true)) {
      if (config.token.empty()) {
        return Error{ErrorCode::kUnavailable, message->login_needed().message()};
      }
      if (auto sent = send(login); !sent) return sent;
    }
    if (!message->has_hello()) continue;
    hello_ = message->hello();
    if (!login_sent && !config.name.empty()) return send(login);
    return {};
  }
}

Result<v1::ServerMessage> StreamClient::next() {
  for (;;) {
    auto message = next_within(std::chrono::hours(1));
    if (!message) return message.error();
    if (*message) return std::move(**message);
  }
}

Result<std::optional<v1::ServerMessage>> StreamClient::next_within(std::chrono::milliseconds time) {
  if (!std::exchange(reading_, true)) {
    read_.reset();
    socket_->async_read(
        incoming_, [this](boost::system::error_code failure, std::size_t /*bytes*/) { read_ = failure; });
  }
  loop_.restart();
  loop_.run_for(time);
  if (!read_) return std::optional<v1::ServerMessage>();
  reading_ = false;
  const std::string reason = socket_->reason().reason.c_str();
  if (*read_ == websocket::error::closed || (*read_ && !reason.empty())) {
    return Error{ErrorCode::kStopped,
                 fmt::format("the server closed{}{}", reason.empty() ? "" : ": ", reason)};
  }
  if (*read_) return broken("reading from the server", *read_);
  v1::ServerMessage message;
  const bool parsed = message.ParseFromArray(incoming_.cdata().data(), static_cast<int>(incoming_.size()));
  incoming_.consume(incoming_.size());
  if (!parsed) return Error{ErrorCode::kBadInput, "the server sent what is no fanlight.v1.ServerMessage"};
  return std::optional(std::move(message));
}

Result<void> StreamClient::send(const v1::ClientMessage& message) {
  const std::string bytes = message.SerializeAsString();
  const auto failure = finish([&](auto done) { socket_->async_write(asio::buffer(bytes), done); });
  if (failure) return broken("writing to the server", failure);
  return {};
}

}  // namespace fanlight
