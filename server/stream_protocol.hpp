#pragma once

#include <cstdint>
#include <string_view>

#include "proto/result.hpp"

namespace fanlight {

inline constexpr std::uint32_t kProtocolVersion = 2;

/// The subprotocol (RFC 6455, 1.9) that both speak, of those that a client offers in order of its liking:
/// "fanlight.v2". Empty where it offers none, and then it is spoken to in the newest. Error: it speaks others
/// only.
Result<std::string_view> agreed_protocol(std::string_view offered);

}  // namespace fanlight
