#include "server/http_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "server/metrics_text.hpp"
#include "server/page_files.hpp"
#include "server/stream_session.hpp"

namespace fanlight {

namespace beast = boost::beast;
namespace http = boost::beast::http;

namespace {

constexpr std::uint32_t kLargestHeaderBytes = 8 << 10;
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
  response.set(http::field::cache_control, "no-cache");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Content-Security-Policy", kContentPolicy);
  response.body() = std::move(body);
  return response;
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

void HttpSession::read() {
  parser_.emplace();
  parser_->header_limit(kLargestHeaderBytes);
  parser_->body_limit(0);
  stream_.expires_after(kRequestTime);
  http::async_read(stream_, incoming_, *parser_,
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
    Response response =
        refusal(http::status::bad_request, fmt::format("the request could not be read ({}), expected a GET "
                                                       "without a body and at most {} bytes of header",
                                                       failure.message(), kLargestHeaderBytes));
    response.keep_alive(false);
    send(std::move(response));
    return;
  }
  const Request request = parser_->release();
  const std::string_view host = request[http::field::host];
  if (context_.loopback_only && !host.empty() && !is_loopback_host(host)) {
    return reply(request,
                 refusal(http::status::misdirected_request,
                         "the request names another host, expected localhost or a loopback address"));
  }
  if (beast::websocket::is_upgrade(request) && request.target() == "/stream") {
    if (from_elsewhere(request)) {
      return reply(request, refusal(http::status::forbidden,
                                    "the stream was asked for by a page of another site, expected our own"));
    }
    std::make_shared<StreamSession>(std::move(stream_), std::move(place_), context_)->start(request);
    return;
  }
  reply(request, respond(request));
}

void HttpSession::reply(const Request& request, Response response) {
  response.keep_alive(request.keep_alive());
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();
  send(std::move(response));
}

HttpSession::Response HttpSession::respond(const Request& request) {
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    return refusal(http::status::method_not_allowed, "expected the method GET or HEAD");
  }
  const std::string_view path = std::string_view(request.target()).substr(0, request.target().find('?'));
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
    return refusal(http::status::not_found,
                   "there is nothing here, expected /, /stream, /healthz or /metrics");
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
  stream_.expires_after(kRequestTime);
  http::async_write(stream_, *response_,
                    [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                      if (failure) return;
                      if (self->response_->keep_alive()) {
                        self->read();
                      } else {
                        beast::error_code ignored;
                        self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
                      }
                    });
}

}  // namespace fanlight
