// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/access/audit_log.hpp"
#include "server/access/authenticator.hpp"
#include "server/api/rest_api.hpp"
#include "server/http/metrics_text.hpp"
#include "server/net/allowed_origins.hpp"
#include "server/net/connection.hpp"
#include "server/net/connection_limit.hpp"
#include "server/stream/stream_session.hpp"

namespace fanlight {

/// One HTTP connection: the page of the viewer, /healthz, /metrics and the REST API under /api. An upgrade at
/// /stream becomes a StreamSession, and a request for a stream of pictures an MjpegSession. A TLS handshake
/// and a request have ten seconds each. Kept alive by its own pending operations. Server thread only.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  struct Dependencies {
    ServerState& state;
    const PictureHub& hub;
    AuditLog& audit;
    Authenticator& access;
    RestApi& rest_api;
    const StreamSession::Dependencies& stream;
    bool hsts;           ///< tell browsers to come over TLS only
    bool loopback_only;  ///< the server listens on loopback, and requests must name a loopback host
    const AllowedOrigins& allowed_origins;
  };

  /// `dependencies` and all that it refers to must outlive the session.
  HttpSession(Connection connection, ConnectionPermit permit, const Dependencies& dependencies);

  /// Performs the TLS handshake, if any, and serves requests.
  void start();

 private:
  void read();
  void header_received(boost::beast::error_code failure);
  /// The refusal of a request whose body is not worth reading; else nothing.
  std::optional<Response> refusal_before_body();
  /// The same for one that sends an object to the archive, which alone may have a large body: sets `sender_`.
  std::optional<Response> refuse_or_admit_object();
  /// Tells the client to send the body that it holds back.
  void send_continue();
  void read_body();
  void received(boost::beast::error_code failure);
  /// Answers an error of HTTP, and ends without a word after one of the connection.
  void refuse_unreadable(boost::beast::error_code failure);
  void serve(Request request);
  /// Serves a request of the REST API.
  void serve_api(const Request& request, const std::optional<Principal>& principal);
  void stream_pictures(const Request& request, const StreamSettings& settings, const Principal& principal);
  RestApi::Answer answer_of(const Request& request);
  /// The response to a request that this server must not serve to anyone; else nothing.
  std::optional<Response> rejection(const Request& request);
  void upgrade(const Request& request, std::optional<Principal> principal);
  /// The principal of the request; empty if it shows no credentials. Error: they are not valid.
  Result<std::optional<Principal>> authenticate(const Request& request);
  Response unauthenticated();
  Response unauthenticated(const Error& reason);
  Response respond(const Request& request, const std::optional<Principal>& principal);
  Response respond_with_page(const Request& request);
  Response health();
  Response readiness();
  void reply(const Request& request, Response response);
  /// Sets the headers of all responses that restrict what a browser does with them.
  void set_policies(const Request& request, Response& response);
  /// Of these, those for pages of other sites.
  void set_sharing(const Request& request, Response& response);
  /// The answer to a browser that asks whether a page of another site may send a request.
  Response preflight(const Request& request);
  Response refusal(boost::beast::http::status status, const std::string& sentence);
  /// A refusal after which the connection is closed.
  Response last_refusal(boost::beast::http::status status, const std::string& sentence);
  Response too_large(boost::beast::http::status status, const std::string& problem);
  void send(Response response);
  void sent();
  /// Drops what the client is still sending, `bytes` at most, and closes: else the answer would be lost with
  /// the connection.
  void drain(std::uint64_t bytes);
  void close();

  const Dependencies& dependencies_;
  ConnectionPermit permit_;
  Connection connection_;
  std::string address_;  // of the client, with port
  boost::beast::flat_buffer incoming_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::optional<Response> response_;
  std::optional<boost::beast::http::response<boost::beast::http::empty_body>> continue_;
  struct Sender {
    Principal principal;
    ArchiveSender::Permit permit;
  };
  std::optional<Sender> sender_;  // of the object whose body is read
  std::string login_reason_;      // why the certificate shown does not suffice; empty: none was shown
  bool without_body_ = false;     // the response to a HEAD request
  bool is_api_ = false;           // refusals are problem details
};

}  // namespace fanlight
