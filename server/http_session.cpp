#include "server/http_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <boost/beast/core/stream_traits.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <nlohmann/json.hpp>

#include "server/metrics_text.hpp"
#include "server/page_files.hpp"
#include "server/script_door.hpp"
#include "server/stream_protocol.hpp"
#include "server/stream_session.hpp"

namespace fanlight {

namespace beast = boost::beast;
namespace http = boost::beast::http;

namespace {

constexpr std::uint32_t kLargestHeaderBytes = 8 << 10;
constexpr std::uint64_t kLargestBodyBytes = 64 << 10;
constexpr auto kRequestTime = std::chrono::seconds(10);

// The page loads nothing from elsewhere and runs nothing that is not a file of ours.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

std::string_view content_type(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  return "image/svg+xml";
}

HttpSession::Response response_with(http::status status, std::string_view type, std::string body) {
  HttpSession::Response response(status, 11);
  response.set(http::field::content_type, type);
  response.body() = std::move(body);
  return response;
}

std::string address_text(Connection& connection) {
  beast::error_code gone;
  const auto peer = connection.next_layer().socket().remote_endpoint(gone);
  if (gone) return "gone";
  const std::string host = peer.address().to_string();
  return peer.address().is_v6() ? fmt::format("[{}]:{}", host, peer.port())
                                : fmt::format("{}:{}", host, peer.port());
}

/// A page of another site may open a WebSocket to us in the user's name; browsers say where it came from.
bool from_elsewhere(const HttpSession::Request& request) {
  const std::string_view origin = request[http::field::origin];
  if (origin.empty()) return false;  // not a browser
  const std::size_t scheme_end = origin.find("://");
  return scheme_end == std::string_view::npos || origin.substr(scheme_end + 3) != request[http::field::host];
}

/// A name that leads to this machine's loopback, whatever its port. A page elsewhere can have a name of its
/// own lead here as well; then the browser takes that page and us for one site, but the Host still is that
/// name.
bool is_loopback_host(std::string_view host) {
  if (const std::size_t colon = host.rfind(':'); colon != std::string_view::npos && !host.ends_with(']')) {
    host = host.substr(0, colon);
  }
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  beast::error_code wrong;
  const auto address = boost::asio::ip::make_address(std::string(host), wrong);
  return host == "localhost" || (!wrong && address.is_loopback());
}

}  // namespace

HttpSession::HttpSession(Connection connection, ConnectionPlace place, const StreamContext& context)
    : place_(std::move(place)),
      connection_(std::move(connection)),
      context_(context),
      address_(address_text(connection_)) {}

void HttpSession::start() {
  if (!connection_.is_tls()) return read();
  beast::get_lowest_layer(connection_).expires_after(kRequestTime);
  connection_.async_handshake([self = shared_from_this()](beast::error_code failure) {
    if (failure) {
      self->context_.counters.handshakes_failed.add();
      if (const std::string wrong = self->connection_.certificate_trouble(); !wrong.empty()) {
        self->context_.audit.note_refusal(
            {.name = "unknown", .address = self->address_},
            {.what = "login", .result = "refused: the certificate shown: " + wrong});
      }
    } else {
      self->read();
    }
  });
}

void HttpSession::read() {
  parser_.emplace();
  parser_->header_limit(kLargestHeaderBytes);
  parser_->body_limit(kLargestBodyBytes);
  beast::get_lowest_layer(connection_).expires_after(kRequestTime);
  http::async_read(connection_, incoming_, *parser_,
                   [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                     self->received(failure);
                   });
}

void HttpSession::received(beast::error_code failure) {
  if (failure == http::error::end_of_stream || failure == beast::error::timeout)
    return;  // closed with the socket
  if (failure) {
    // Only what HTTP itself finds wrong can be answered; a broken connection cannot.
    if (failure.category() != make_error_code(http::error::bad_method).category()) return;
    Response response = refusal(
        http::status::bad_request,
        fmt::format("the request could not be read ({}), expected at most {} bytes of header and {} of body",
                    failure.message(), kLargestHeaderBytes, kLargestBodyBytes));
    response.keep_alive(false);
    send(std::move(response));
    return;
  }
  serve(parser_->release());
}

void HttpSession::serve(const Request& request) {
  const std::string_view host = request[http::field::host];
  if (context_.loopback_only && !host.empty() && !is_loopback_host(host)) {
    return reply(request,
                 refusal(http::status::misdirected_request,
                         "the request names another host, expected localhost or a loopback address"));
  }
  if (from_elsewhere(request)) {
    context_.audit.note_refusal({.name = "unknown", .address = address_},
                                {.what = "request", .result = "refused: from a page of another site"},
                                {{"origin", std::string(request[http::field::origin].substr(0, 64))}});
    Response response =
        refusal(http::status::forbidden, "the request comes from a page of another site, expected our own");
    response.keep_alive(false);
    return send(std::move(response));
  }
  const bool reads = request.method() == http::verb::get || request.method() == http::verb::head;
  if (reads && !request.body().empty()) {
    Response response = refusal(http::status::bad_request, "a GET came with a body, expected none");
    response.keep_alive(false);
    return send(std::move(response));
  }
  auto visitor = recognise(request);
  if (!visitor) {
    const bool wait = visitor.error().code == ErrorCode::kUnavailable;
    Response response =
        refusal(wait ? http::status::too_many_requests : http::status::unauthorized, visitor.error().message);
    response.set(http::field::www_authenticate, "Bearer");
    return reply(request, std::move(response));
  }
  if (beast::websocket::is_upgrade(request) && request.target() == "/stream") {
    return upgrade(request, std::move(*visitor));
  }
  reply(request, respond(request, *visitor));
}

Result<std::optional<Visitor>> HttpSession::recognise(const Request& request) {
  if (!context_.access.asks()) return std::optional(context_.access.anyone(address_));
  constexpr std::string_view kBearer = "Bearer ";
  const std::string_view given = request[http::field::authorization];
  if (given.starts_with(kBearer)) {
    auto visitor = context_.access.by_token(given.substr(kBearer.size()), address_);
    if (!visitor) return visitor.error();
    return std::optional(std::move(*visitor));
  }
  if (const auto fingerprint = connection_.client_fingerprint()) {
    auto visitor = context_.access.by_certificate(*fingerprint, address_);
    if (!visitor) return visitor.error();
    return std::optional(std::move(*visitor));
  }
  return std::optional<Visitor>();
}

void HttpSession::upgrade(const Request& request, std::optional<Visitor> visitor) {
  const auto protocol = agreed_protocol(request["Sec-WebSocket-Protocol"]);
  if (!protocol) return reply(request, refusal(http::status::bad_request, protocol.error().message));
  std::make_shared<StreamSession>(std::move(connection_), std::move(place_), context_, address_)
      ->start(request, *protocol, std::move(visitor));
}

void HttpSession::reply(const Request& request, Response response) {
  response.keep_alive(request.keep_alive());
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Content-Security-Policy", kContentPolicy);
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  if (connection_.is_tls()) response.set("Strict-Transport-Security", "max-age=31536000");
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();
  send(std::move(response));
}

HttpSession::Response HttpSession::respond(const Request& request, const std::optional<Visitor>& visitor) {
  const std::string_view path = std::string_view(request.target()).substr(0, request.target().find('?'));
  // The page and the health tell nothing of what is scanned, and the page must be there to log in.
  const bool guarded = path == "/metrics" || path.starts_with("/api/");
  if (guarded && !visitor) {
    Response response =
        refusal(http::status::unauthorized, "expected a token, as Authorization: Bearer TOKEN");
    response.set(http::field::www_authenticate, "Bearer");
    return response;
  }
  if (path.starts_with("/api/")) {
    Response response = ScriptDoor(context_).respond(request, path, *visitor);
    if (http::to_status_class(response.result()) == http::status_class::client_error) {
      context_.counters.requests_refused.add();
    }
    return response;
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return refusal(http::status::method_not_allowed, "expected the method GET or HEAD");
  }
  if (path == "/healthz") {
    std::string state = context_.source_state();
    const bool healthy = state == "running" || state == "ended";
    // Fanlight is well where somebody pulled a plug.
    if (healthy && context_.probe.lost()) state = "waits for a probe that was lost";
    return response_with(healthy ? http::status::ok : http::status::service_unavailable,
                         "text/plain; charset=utf-8",
                         fmt::format("{}; source {}\n", healthy ? "ok" : "failing", state));
  }
  if (path == "/metrics") {
    return response_with(http::status::ok, "text/plain; version=0.0.4; charset=utf-8",
                         metrics_text(context_));
  }
  const std::string_view name =
      path == "/" ? "index.html" : path.substr(std::min<std::size_t>(1, path.size()));
  const auto file = std::ranges::find(page_files(), name, &PageFile::name);
  if (file == page_files().end()) {
    return refusal(
        http::status::not_found,
        "there is nothing here, expected /, /stream, /healthz, /metrics, /api/scene or /api/picture.png");
  }
  return response_with(http::status::ok, content_type(name), std::string(file->bytes));
}

HttpSession::Response HttpSession::refusal(http::status status, const std::string& sentence) {
  context_.counters.requests_refused.add();
  return response_with(status, "text/plain; charset=utf-8", sentence + "\n");
}

void HttpSession::send(Response response) {
  if (!response.has_content_length()) response.prepare_payload();
  response_ = std::move(response);
  beast::get_lowest_layer(connection_).expires_after(kRequestTime);
  http::async_write(connection_, *response_,
                    [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                      if (failure) return;
                      if (self->response_->keep_alive()) {
                        self->read();
                      } else {
                        beast::get_lowest_layer(self->connection_).expires_after(kRequestTime);
                        self->connection_.async_shutdown([self](beast::error_code /*closed either way*/) {});
                      }
                    });
}

}  // namespace fanlight
