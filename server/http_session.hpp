#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <memory>
#include <optional>

#include "server/connection.hpp"
#include "server/stream_context.hpp"

namespace fanlight {

/// One HTTP connection: the viewer's page, /healthz, /metrics and the scripts' door under /api; an upgrade at
/// /stream becomes a StreamSession. Ten seconds for a TLS handshake and for a request. Kept alive by its own
/// pending operations. Server thread only.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  HttpSession(Connection connection, ConnectionPlace place, const StreamContext& context);

  /// Shakes hands where there is TLS, and serves.
  void start();

 private:
  void read();
  void received(boost::beast::error_code failure);
  void serve(const Request& request);
  void upgrade(const Request& request, std::optional<Visitor> visitor);
  Result<std::optional<Visitor>> recognise(const Request& request);
  Response respond(const Request& request, const std::optional<Visitor>& visitor);
  void reply(const Request& request, Response response);
  Response refusal(boost::beast::http::status status, const std::string& sentence);
  void send(Response response);

  ConnectionPlace place_;
  Connection connection_;
  StreamContext context_;
  std::string address_;
  boost::beast::flat_buffer incoming_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::optional<Response> response_;
};

}  // namespace fanlight
