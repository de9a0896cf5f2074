// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

inline constexpr std::uint32_t kProtocolVersion = 2;

/// Chooses the subprotocol (RFC 6455, 1.9), "fanlight.v2", from those that a client offers in order of its
/// preference. Empty if it offers none; the session then uses the newest version. Error: the server supports
/// none of those offered.
Result<std::string_view> agreed_protocol(std::string_view offered);

}  // namespace fanlight
