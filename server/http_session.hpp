#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <memory>
#include <optional>

#include "server/stream_context.hpp"

namespace fanlight {

/// One HTTP connection: the viewer's page, /healthz and /metrics; an upgrade at /stream becomes a
/// StreamSession. GET and HEAD only, no bodies, ten seconds for a request. Kept alive by its own pending
/// operations. Server thread only.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  HttpSession(boost::asio::ip::tcp::socket socket, ConnectionPlace place, const StreamContext& context)
      : place_(std::move(place)), stream_(std::move(socket)), context_(context) {}

  void read();

 private:
  void received(boost::beast::error_code failure);
  Response respond(const Request& request);
  void reply(const Request& request, Response response);
  Response refusal(boost::beast::http::status status, const std::string& sentence);
  void send(Response response);

  ConnectionPlace place_;
  boost::beast::tcp_stream stream_;
  StreamContext context_;
  boost::beast::flat_buffer incoming_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<Response> response_;
};

}  // namespace fanlight
