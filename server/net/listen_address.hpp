// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// Parses "127.0.0.1:8080" or "[::1]:8080". Port 0 means any free port. Names are refused, because a name
/// could resolve to any address.
Result<boost::asio::ip::tcp::endpoint> parse_listen_address(std::string_view text);

/// The URL of the page: "http://127.0.0.1:8080/".
std::string page_url(const boost::asio::ip::tcp::endpoint& endpoint, bool tls);

}  // namespace fanlight
