// SPDX-License-Identifier: Apache-2.0
#include "server/net/listen_address.hpp"

#include <fmt/format.h>

#include <boost/asio/ip/address.hpp>
#include <charconv>

namespace fanlight {

Result<boost::asio::ip::tcp::endpoint> parse_listen_address(std::string_view text) {
  const Error refusal{
      ErrorCode::kInvalidArgument,
      fmt::format("the address \"{}\" is not one to listen on, expected ADDRESS:PORT such as "
                  "127.0.0.1:8080, localhost:8080 or [::1]:8080, or a port alone, from 0 (any "
                  "free one) to 65535",
                  text)};
  const std::size_t colon = text.rfind(':');
  // Of this machine, where nothing else is said.
  std::string_view host = colon == std::string_view::npos ? "localhost" : text.substr(0, colon);
  const std::string_view port_text = colon == std::string_view::npos ? text : text.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);

  std::uint16_t port = 0;
  const auto [end, failure] = std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  if (failure != std::errc{} || end != port_text.data() + port_text.size()) return refusal;
  // By RFC 6761 it is this machine, whatever a resolver says.
  if (host == "localhost") host = "127.0.0.1";
  boost::system::error_code wrong;
  const auto address = boost::asio::ip::make_address(std::string(host), wrong);
  if (wrong) return refusal;
  return boost::asio::ip::tcp::endpoint(address, port);
}

std::string page_url(const boost::asio::ip::tcp::endpoint& endpoint, bool tls) {
  const auto address = endpoint.address();
  const std::string host = address.is_v6() ? fmt::format("[{}]", address.to_string()) : address.to_string();
  return fmt::format("{}://{}:{}/", tls ? "https" : "http", host, endpoint.port());
}

}  // namespace fanlight
