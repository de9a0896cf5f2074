// SPDX-License-Identifier: Apache-2.0
#include "server/client/server_url.hpp"

#include <fmt/format.h>

#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
#include <optional>

namespace fanlight {

namespace {

namespace urls = boost::urls;

struct Scheme {
  bool tls;
  const char* port;
};

constexpr const char* kUsualPort = "8080";  // of a server that was started without --listen

std::optional<Scheme> scheme_of(const urls::url_view& url) {
  switch (url.scheme_id()) {
    case urls::scheme::http:
    case urls::scheme::ws:
      return Scheme{.tls = false, .port = "80"};
    case urls::scheme::https:
    case urls::scheme::wss:
      return Scheme{.tls = true, .port = "443"};
    default:
      return std::nullopt;
  }
}

/// Takes the zone with its '%' out of an IPv6 address: RFC 3986 does not know zones.
std::string take_zone(std::string& url) {
  const std::size_t begin = url.find('%');
  const std::size_t end = url.find(']');
  if (!(begin < end) || end == std::string::npos) return "";
  std::string zone = url.substr(begin, end - begin);
  url.erase(begin, end - begin);
  return zone;
}

}  // namespace

std::string ServerUrl::host_and_port() const {
  return host.find(':') == std::string::npos ? fmt::format("{}:{}", host, port)
                                             : fmt::format("[{}]:{}", host, port);
}

std::string ServerUrl::text() const {
  return fmt::format("{}://{}", tls ? "https" : "http", host_and_port());
}

Result<ServerUrl> parse_server_url(std::string_view text) {
  const Error refusal{
      ErrorCode::kInvalidArgument,
      fmt::format("{} is no address of a server, expected one such as http://127.0.0.1:8080", text)};
  // "scanner:8080", "scanner" or "8080" is how people write it.
  const bool by_hand = text.find("://") == std::string_view::npos && !text.starts_with("http:");
  const bool port_alone = !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
  std::string without_zone = port_alone ? fmt::format("http://127.0.0.1:{}", text)
                             : by_hand  ? fmt::format("http://{}", text)
                                        : std::string(text);
  const std::string zone = take_zone(without_zone);
  const auto url = urls::parse_uri(without_zone);
  if (!url) return refusal;
  const auto scheme = scheme_of(*url);
  if (!scheme || url->has_userinfo() || url->host_address().empty()) return refusal;
  // Boost.URL 1.81 takes text behind the ']' of a host for the path.
  const std::string_view path = url->encoded_path();
  if (!path.empty() && !path.starts_with('/')) return refusal;
  if (!zone.empty() && url->host_type() != urls::host_type::ipv6) return refusal;
  // port_number() is 0 for a port that is empty or too large.
  if (url->has_port() && url->port_number() == 0) return refusal;
  return ServerUrl{.tls = scheme->tls,
                   .host = url->host_address() + zone,
                   .port = url->has_port() ? std::to_string(url->port_number())
                           : by_hand       ? kUsualPort
                                           : scheme->port};
}

}  // namespace fanlight
