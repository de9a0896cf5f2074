#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <string_view>

#include "proto/result.hpp"

namespace fanlight {

/// "127.0.0.1:8080" or "[::1]:8080"; port 0 takes a free one. Numbers only: a name could resolve to anything.
Result<boost::asio::ip::tcp::endpoint> parse_listen_address(std::string_view text);

/// The page's address as a person types it: "http://127.0.0.1:8080/".
std::string page_url(const boost::asio::ip::tcp::endpoint& endpoint, bool tls);

}  // namespace fanlight
