// SPDX-License-Identifier: Apache-2.0
#include "server/http/http_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/beast/core/stream_traits.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <nlohmann/json.hpp>

#include "server/api/problem.hpp"
#include "server/http/request_rules.hpp"
#include "server/net/request_host.hpp"
#include "server/stream/mjpeg_session.hpp"
#include "server/stream/page_files.hpp"
#include "server/stream/stream_protocol.hpp"

namespace fanlight {

namespace beast = boost::beast;
namespace http = boost::beast::http;

namespace {

constexpr std::uint32_t kLargestHeaderBytes = 8 << 10;
constexpr std::uint64_t kLargestBodyBytes = 64 << 10;
constexpr std::uint64_t kLargestObjectBytes = 16 << 20;  // a picture in base64; for operators
constexpr auto kRequestTime = std::chrono::seconds(10);
constexpr auto kStillTime = std::chrono::seconds(60);
constexpr auto kDrainTime = std::chrono::seconds(2);

// The page loads files of this server only, and runs no script but those.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors ";
constexpr const char* kExposedHeaders =
    "X-Fanlight-Picture-Id, X-Fanlight-Volume-Id, X-Fanlight-Scene-Revision, X-Fanlight-Liveness, "
    "X-Fanlight-Origin, Retry-After";

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

std::string_view path_of(const HttpSession::Request& request) {
  return std::string_view(request.target()).substr(0, request.target().find('?'));
}

/// Whether a path needs credentials. The page and the health check show nothing of the scan, and the page is
/// needed to log in. The stream asks for a login by itself.
bool is_guarded(std::string_view path) {
  return path == "/metrics" || is_api(path);
}

bool sends_object(const HttpSession::Request& request) {
  return request.method() == http::verb::post && path_of(request) == "/api/archive";
}

bool is_read(const HttpSession::Request& request) {
  return request.method() == http::verb::get || request.method() == http::verb::head;
}

}  // namespace

HttpSession::HttpSession(Connection connection, ConnectionPermit permit, const Dependencies& dependencies)
    : dependencies_(dependencies),
      permit_(std::move(permit)),
      connection_(std::move(connection)),
      address_(address_text(connection_)) {}

void HttpSession::start() {
  permit_.on_eviction([weak = weak_from_this()] {
    if (const auto self = weak.lock()) beast::get_lowest_layer(self->connection_).close();
  });
  if (!connection_.is_tls()) return read();
  beast::get_lowest_layer(connection_).expires_after(kRequestTime);
  connection_.async_handshake(
      boost::asio::ssl::stream_base::server, [self = shared_from_this()](beast::error_code failure) {
        if (failure) {
          self->dependencies_.state.counters.handshakes_failed.add();
          if (const std::string wrong = self->connection_.certificate_trouble(); !wrong.empty()) {
            self->dependencies_.audit.note(
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
  sender_.reset();
  parser_->header_limit(kLargestHeaderBytes);
  parser_->body_limit(kLargestObjectBytes);  // until the header says whose body it is
  beast::get_lowest_layer(connection_).expires_after(kRequestTime);
  http::async_read_header(connection_, incoming_, *parser_,
                          [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                            self->header_received(failure);
                          });
}

void HttpSession::header_received(beast::error_code failure) {
  if (failure) return refuse_unreadable(failure);
  without_body_ = parser_->get().method() == http::verb::head;
  is_api_ = is_api(path_of(parser_->get()));
  if (const auto wrong = violation_of(parser_->get()))
    return send(last_refusal(wrong->status, wrong->sentence));
  if (!to_origin_form(parser_->get())) {
    return send(
        last_refusal(http::status::bad_request, "the target is neither a path nor a URL, expected one"));
  }
  is_api_ = is_api(path_of(parser_->get()));  // of the absolute form too
  if (auto refused = refusal_before_body()) return send(*std::move(refused));
  if (waits_for_continue(parser_->get()) && !parser_->is_done()) return send_continue();
  read_body();
}

std::optional<HttpSession::Response> HttpSession::refusal_before_body() {
  if (sends_object(parser_->get())) return refuse_or_admit_object();
  if (parser_->content_length().value_or(0) > kLargestBodyBytes)
    return too_large(http::status::payload_too_large, "the body is too large");
  parser_->body_limit(kLargestBodyBytes);
  return std::nullopt;
}

std::optional<HttpSession::Response> HttpSession::refuse_or_admit_object() {
  const Request& header = parser_->get();
  if (auto rejected = rejection(header)) return rejected;
  const auto last = [](Response response) {
    response.keep_alive(false);
    return std::optional(std::move(response));
  };
  auto principal = authenticate(header);
  if (!principal) return last(unauthenticated(principal.error()));
  if (!*principal) return last(unauthenticated());
  permit_.authenticated();
  auto admission = dependencies_.rest_api.admit_object(header, **principal);
  if (admission.refusal) {
    dependencies_.state.counters.requests_refused.add();
    return last(*std::move(admission.refusal));
  }
  sender_.emplace(Sender{**std::move(principal), std::move(admission.permit)});
  beast::get_lowest_layer(connection_).expires_after(kStillTime);
  return std::nullopt;
}

void HttpSession::send_continue() {
  continue_.emplace(http::status::continue_, 11);
  http::async_write(connection_, *continue_,
                    [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                      if (!failure) self->read_body();
                    });
}

void HttpSession::read_body() {
  http::async_read(connection_, incoming_, *parser_,
                   [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                     self->received(failure);
                   });
}

void HttpSession::received(beast::error_code failure) {
  if (failure) return refuse_unreadable(failure);
  serve(parser_->release());
}

void HttpSession::refuse_unreadable(beast::error_code failure) {
  if (failure == http::error::end_of_stream || failure == beast::error::timeout)
    return;  // the destructor closes the socket
  // Errors of HTTP itself can be answered; those of the connection cannot.
  if (failure.category() != make_error_code(http::error::bad_method).category()) return;
  const auto status = failure == http::error::body_limit     ? http::status::payload_too_large
                      : failure == http::error::header_limit ? http::status::request_header_fields_too_large
                                                             : http::status::bad_request;
  send(too_large(status, failure.message()));
}

HttpSession::Response HttpSession::too_large(http::status status, const std::string& problem) {
  return last_refusal(
      status,
      fmt::format("the request could not be read ({}), expected at most {} bytes of header and {} of body",
                  problem, kLargestHeaderBytes,
                  sends_object(parser_->get()) ? kLargestObjectBytes : kLargestBodyBytes));
}

HttpSession::Response HttpSession::unauthenticated() {
  return unauthenticated({ErrorCode::kInvalidArgument, "expected a token, as Authorization: Bearer TOKEN"});
}

HttpSession::Response HttpSession::unauthenticated(const Error& reason) {
  const bool wait = reason.code == ErrorCode::kUnavailable;
  Response response =
      refusal(wait ? http::status::too_many_requests : http::status::unauthorized, reason.message);
  response.set(http::field::www_authenticate, "Bearer");
  return response;
}

void HttpSession::serve(Request request) {
  if (auto rejected = rejection(request)) return send(std::move(*rejected));
  if (const auto sender = std::exchange(sender_, std::nullopt)) {
    return dependencies_.rest_api.send_object(std::move(request.body()), sender->principal, sender->permit,
                                              answer_of(request));
  }
  const bool asks_before = request.method() == http::verb::options &&
                           request.count(http::field::access_control_request_method) > 0;
  if (asks_before && dependencies_.allowed_origins.has(request[http::field::origin]))
    return reply(request, preflight(request));
  auto principal = authenticate(request);
  if (!principal) return reply(request, unauthenticated(principal.error()));
  if (*principal) permit_.authenticated();
  if (beast::websocket::is_upgrade(request) && request.target() == "/stream") {
    return upgrade(request, std::move(*principal));
  }
  if (is_api(path_of(request))) return serve_api(request, *principal);
  reply(request, respond(request, *principal));
}

RestApi::Answer HttpSession::answer_of(const Request& request) {
  return
      [self = shared_from_this(), kept = std::make_shared<const Request>(request.base())](Response response) {
        if (http::to_status_class(response.result()) == http::status_class::client_error)
          self->dependencies_.state.counters.requests_refused.add();
        self->reply(*kept, std::move(response));
      };
}

void HttpSession::serve_api(const Request& request, const std::optional<Principal>& principal) {
  if (!principal) return reply(request, unauthenticated());
  if (auto stream = dependencies_.rest_api.stream_settings(request)) {
    if (const auto* settings = std::get_if<StreamSettings>(&*stream))
      return stream_pictures(request, *settings, *principal);
    return answer_of(request)(std::get<Response>(std::move(*stream)));
  }
  dependencies_.rest_api.serve(request, *principal, answer_of(request), now_ns());
}

void HttpSession::stream_pictures(const Request& request, const StreamSettings& settings,
                                  const Principal& principal) {
  Response head(http::status::ok, 11);
  set_policies(request, head);
  if (const auto room =
          dependencies_.stream.shared.hub.has_room(0, has_role(principal.role, kEncodesUnlimited), settings);
      !room) {
    return reply(request, refusal(http::status::service_unavailable, room.error().message));
  }
  std::make_shared<MjpegSession>(std::move(connection_), std::move(permit_), dependencies_.stream, address_)
      ->start(std::move(head), principal, settings, without_body_);
}

std::optional<HttpSession::Response> HttpSession::rejection(const Request& request) {
  const std::string_view host = request[http::field::host];
  if (dependencies_.loopback_only && !host.empty() && !is_loopback_host(host)) {
    return last_refusal(http::status::misdirected_request,
                        "the request names another host, expected localhost or a loopback address");
  }
  const std::string_view origin = request[http::field::origin];  // only browsers send it
  if (!origin.empty() && !is_origin_of_host(origin, request[http::field::host], connection_.is_tls()) &&
      !dependencies_.allowed_origins.has(origin)) {
    dependencies_.audit.note({.name = "unknown", .address = address_},
                             {.what = "request", .result = "refused: from a page of another site"},
                             {{"origin", std::string(origin.substr(0, 64))}});
    return last_refusal(http::status::forbidden,
                        "the request comes from a page of another site, expected our own");
  }
  if (is_read(request) && !request.body().empty())
    return last_refusal(http::status::bad_request, "a GET came with a body, expected none");
  return std::nullopt;
}

Result<std::optional<Principal>> HttpSession::authenticate(const Request& request) {
  if (!dependencies_.access.asks()) return std::optional(dependencies_.access.anyone(address_));
  constexpr std::string_view kBearer = "Bearer ";
  const std::string_view given = request[http::field::authorization];
  // The scheme is the same in upper and lower case (RFC 9110, section 11.1).
  if (beast::iequals(given.substr(0, kBearer.size()), kBearer)) {
    auto principal = dependencies_.access.by_token(given.substr(kBearer.size()), address_);
    if (principal) return std::optional(std::move(*principal));
    dependencies_.state.counters.logins_refused.add();
    return principal.error();
  }
  const bool stream = path_of(request) == "/stream";
  // A request for the page alone needs no certificate, so none is judged.
  if (!stream && !is_guarded(path_of(request))) return std::optional<Principal>();
  if (const auto fingerprint = connection_.client_fingerprint()) {
    auto principal = dependencies_.access.by_certificate(*fingerprint, address_);
    if (principal) return std::optional(std::move(*principal));
    dependencies_.state.counters.logins_refused.add();
    if (!stream) return principal.error();
    login_reason_ = principal.error().message;  // a person can still log in with a token
  }
  return std::optional<Principal>();
}

void HttpSession::upgrade(const Request& request, std::optional<Principal> principal) {
  const auto protocol = agreed_protocol(request["Sec-WebSocket-Protocol"]);
  if (!protocol) return reply(request, refusal(http::status::bad_request, protocol.error().message));
  if (!is_websocket_key(request[http::field::sec_websocket_key]))
    return reply(request, refusal(http::status::bad_request,
                                  "Sec-WebSocket-Key is not 16 bytes in base64, expected a random key"));
  std::make_shared<StreamSession>(std::move(connection_), std::move(permit_), dependencies_.stream, address_)
      ->start(request, *protocol, std::move(principal), login_reason_);
}

void HttpSession::reply(const Request& request, Response response) {
  response.keep_alive(request.keep_alive());
  set_policies(request, response);
  response.prepare_payload();
  send(std::move(response));
}

void HttpSession::set_policies(const Request& request, Response& response) {
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Content-Security-Policy", kContentPolicy + dependencies_.allowed_origins.sources());
  response.set("Referrer-Policy", "no-referrer");
  set_sharing(request, response);
  if (dependencies_.hsts && connection_.is_tls())
    response.set("Strict-Transport-Security", "max-age=31536000");
}

void HttpSession::set_sharing(const Request& request, Response& response) {
  const AllowedOrigins& allowed = dependencies_.allowed_origins;
  const std::string_view origin = request[http::field::origin];
  // An <img> sends no Origin, but the address of its page.
  const bool is_shared = allowed.has(origin) || allowed.has_page(request[http::field::referer]);
  response.set("Cross-Origin-Resource-Policy", is_shared ? "cross-origin" : "same-origin");
  if (allowed.empty()) return;
  response.insert(http::field::vary, "Origin, Referer");
  if (!allowed.has(origin)) return;
  response.set(http::field::access_control_allow_origin, origin);
  response.set(http::field::access_control_allow_credentials, "true");  // a certificate is one
  response.set(http::field::access_control_expose_headers, kExposedHeaders);
}

HttpSession::Response HttpSession::preflight(const Request& request) {
  Response response(http::status::no_content, 11);
  std::string methods = allowed_methods(path_of(request));
  response.set(http::field::access_control_allow_methods, methods.empty() ? "GET, HEAD" : methods);
  response.set(http::field::access_control_allow_headers,
               fmt::format("Authorization, Content-Type, {}", kControlKeyHeader));
  response.set(http::field::access_control_max_age, "600");
  return response;
}

HttpSession::Response HttpSession::respond(const Request& request,
                                           const std::optional<Principal>& principal) {
  const std::string_view path = path_of(request);
  if (is_guarded(path) && !principal) return unauthenticated();
  if (!is_read(request)) {
    Response response = refusal(http::status::method_not_allowed, "expected the method GET or HEAD");
    response.set(http::field::allow, "GET, HEAD");
    return response;
  }
  if (path == "/healthz") return health();
  if (path == "/readyz") return readiness();
  if (path == "/metrics") {
    return response_with(http::status::ok, "text/plain; version=0.0.4; charset=utf-8",
                         metrics_text(dependencies_.state, dependencies_.hub));
  }
  return respond_with_page(request);
}

namespace {

// A driver that compiles may be silent for this long; a restart would only let it begin again.
constexpr std::int64_t kLongestCompilationNs = 15'000'000'000;

}  // namespace

HttpSession::Response HttpSession::health() {
  using Cause = PictureLiveness::Cause;
  const PictureLiveness::Report& report = dependencies_.state.liveness.report();
  // A supervisor that restarts the server on 503 must not do so because a probe was unplugged or a recording
  // ended.
  const bool source_over =
      report.cause == Cause::kSourceFailed && dependencies_.state.source_state() != "running";
  const bool failing = source_over || report.cause == Cause::kGpuHung || report.cause == Cause::kGpuRemade ||
                       dependencies_.state.liveness.gpu_lost_ns() > 0 ||
                       dependencies_.state.liveness.driver_silent_ns() > kLongestCompilationNs;
  const std::string source =
      dependencies_.state.probe.lost() ? "probe lost" : dependencies_.state.source_state();
  const std::string age = report.age_s < 0 ? "" : fmt::format(", {:.1f} s old", report.age_s);
  return response_with(failing ? http::status::service_unavailable : http::status::ok,
                       "text/plain; charset=utf-8",
                       fmt::format("{}; source {}; picture {}{}; {}\n", failing ? "failing" : "ok", source,
                                   PictureLiveness::name(report.state), age, report.sentence));
}

HttpSession::Response HttpSession::readiness() {
  const PictureLiveness::Report& report = dependencies_.state.liveness.report();
  return response_with(report.ready() ? http::status::ok : http::status::service_unavailable,
                       "text/plain; charset=utf-8",
                       fmt::format("{}; {}\n", report.ready() ? "ready" : "not ready", report.sentence));
}

HttpSession::Response HttpSession::respond_with_page(const Request& request) {
  const std::string_view path = path_of(request);
  const std::string_view name =
      path == "/" ? "index.html" : path.substr(std::min<std::size_t>(1, path.size()));
  const auto file = std::ranges::find(page_files(), name, &PageFile::name);
  if (file == page_files().end()) {
    return refusal(http::status::not_found,
                   "there is nothing here, expected /, /stream, /healthz, /readyz, /metrics or a path that "
                   "GET /api lists");
  }
  // A client that loads the page connects as a display next: its first picture is rendered meanwhile.
  if (path == "/" && !dependencies_.access.asks()) dependencies_.state.demand.asked(now_ns());
  const bool compressed = accepts_gzip(request);
  Response response =
      response_with(http::status::ok, content_type(name), std::string(compressed ? file->gzip : file->bytes));
  response.set(http::field::vary, "Accept-Encoding");
  if (compressed) response.set(http::field::content_encoding, "gzip");
  return response;
}

HttpSession::Response HttpSession::refusal(http::status status, const std::string& sentence) {
  dependencies_.state.counters.requests_refused.add();
  if (is_api_) return fanlight::refusal(status, sentence);
  return response_with(status, "text/plain; charset=utf-8", sentence + "\n");
}

HttpSession::Response HttpSession::last_refusal(http::status status, const std::string& sentence) {
  Response response = refusal(status, sentence);
  response.keep_alive(false);
  return response;
}

void HttpSession::send(Response response) {
  if (!response.has_content_length()) response.prepare_payload();
  if (without_body_) response.body().clear();  // the length stays
  response_ = std::move(response);
  beast::get_lowest_layer(connection_).expires_after(kRequestTime);
  http::async_write(connection_, *response_,
                    [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                      if (!failure) self->sent();
                    });
}

void HttpSession::sent() {
  if (response_->keep_alive()) return read();
  if (!parser_->is_header_done() || parser_->is_done()) return close();
  const std::uint64_t unread = parser_->content_length_remaining().value_or(kLargestObjectBytes);
  if (unread <= incoming_.size()) return close();
  beast::get_lowest_layer(connection_).expires_after(kDrainTime);
  drain(unread - incoming_.size());
}

void HttpSession::drain(std::uint64_t bytes) {
  incoming_.clear();
  connection_.async_read_some(
      incoming_.prepare(kLargestHeaderBytes),
      [self = shared_from_this(), bytes](beast::error_code failure, std::size_t read) {
        if (failure || read >= bytes) return self->close();
        self->drain(bytes - read);
      });
}

void HttpSession::close() {
  beast::get_lowest_layer(connection_).expires_after(kRequestTime);
  connection_.async_shutdown([self = shared_from_this()](beast::error_code /*closed either way*/) {});
}

}  // namespace fanlight
