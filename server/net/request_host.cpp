// SPDX-License-Identifier: Apache-2.0
#include "server/net/request_host.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <boost/url/authority_view.hpp>
#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
#include <cctype>
#include <string>

namespace fanlight {

namespace urls = boost::urls;

bool is_loopback_host(std::string_view host) {
  const auto authority = urls::parse_authority(host);
  if (!authority || authority->has_userinfo()) return false;
  std::string name = authority->host_address();
  // Names are the same in upper and lower case, and with the dot of the root behind them (RFC 1034, 3.1).
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  if (name.ends_with('.')) name.pop_back();
  boost::system::error_code wrong;
  const auto address = boost::asio::ip::make_address(name, wrong);
  return name == "localhost" || (!wrong && address.is_loopback());
}

bool is_origin_of_host(std::string_view origin, std::string_view host, bool is_tls) {
  const auto url = urls::parse_uri(origin);
  if (is_tls && url && url->scheme() != "https") return false;
  if (!url || !url->has_authority() || url->encoded_resource() != "") return false;
  return std::string_view(url->encoded_authority()) == host;
}

}  // namespace fanlight
