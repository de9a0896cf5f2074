// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace fanlight {

/// Whether a Host header ("localhost:8080", "[::1]") names this machine's loopback, with any port. An
/// attacker can make a name of their own resolve to the loopback address (DNS rebinding). The browser then
/// takes that page and this server for one site, but the Host header still has that name.
bool is_loopback_host(std::string_view host);

/// Whether a page with this Origin header was served under this Host header. Browsers send the origin of the
/// page. A page of another site could otherwise open a WebSocket to this server in the user's name. `is_tls`:
/// this server speaks TLS, so a page that came without it is another one. Without TLS either scheme will do,
/// because a proxy may have ended TLS.
bool is_origin_of_host(std::string_view origin, std::string_view host, bool is_tls);

}  // namespace fanlight
