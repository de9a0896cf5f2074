// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fanlight {

/// Whose user data it is: proto/RTP.md.
inline constexpr std::array<std::uint8_t, 16> kPictureDataUuid = {
    0x5d, 0x41, 0x2e, 0x9c, 0x7b, 0x60, 0x4f, 0x3a, 0x9e, 0x18, 0xc2, 0x6f, 0x0b, 0x84, 0xd7, 0x35};

/// A NAL unit with one SEI message "user data unregistered" (H.264, D.1.7): the UUID, then `data`. Bytes that
/// would look like a start code are escaped.
std::vector<std::uint8_t> user_data_sei(std::string_view data);

/// The data of such a unit. nullopt: it is something else, or cut off.
std::optional<std::string> read_user_data_sei(std::span<const std::uint8_t> unit);

}  // namespace fanlight
