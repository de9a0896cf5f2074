// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// What a client needs from the URL of a server.
struct ServerUrl {
  bool tls = false;
  std::string host;  ///< a name or an address, without brackets
  std::string port;  ///< in decimal; the default one of the scheme if the URL has none

  /// For the Host header: "127.0.0.1:8080", "[::1]:8080".
  std::string host_and_port() const;
  /// "http://127.0.0.1:8080", "https://[::1]:8080".
  std::string text() const;
};

/// Parses an absolute URL (RFC 3986) with the scheme http, https, ws or wss. An IPv6 address may have a zone,
/// as in "http://[fe80::1%eth0]:8080". Ignores path, query and fragment. Error, kInvalidArgument: anything
/// else, also user information, an empty port and a port above 65535.
Result<ServerUrl> parse_server_url(std::string_view text);

}  // namespace fanlight
