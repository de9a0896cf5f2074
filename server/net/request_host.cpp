// SPDX-License-Identifier: Apache-2.0
#include "server/net/request_host.hpp"

#include <boost/asio/ip/address.hpp>
#include <boost/url/authority_view.hpp>
#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>

namespace fanlight {

namespace urls = boost::urls;

bool is_loopback_host(std::string_view host) {
  const auto authority = urls::parse_authority(host);
  if (!authority || authority->has_userinfo()) return false;
  const std::string name = authority->host_address();
  boost::system::error_code wrong;
  const auto address = boost::asio::ip::make_address(name, wrong);
  return name == "localhost" || (!wrong && address.is_loopback());
}

bool is_origin_of_host(std::string_view origin, std::string_view host) {
  const auto url = urls::parse_uri(origin);
  if (!url || !url->has_authority() || url->encoded_resource() != "") return false;
  return std::string_view(url->encoded_authority()) == host;
}

}  // namespace fanlight
