// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace fanlight {

/// Where frames come from, at the first of several senders. The numbers are those of Liveness.Origin in
/// fanlight.proto.
enum class FrameOrigin : std::uint8_t {
  kProbe,
  kUnknown,  ///< a sender that does not say it
  kSimulated,
  kRecording,
};
inline constexpr auto kFrameOriginNames =
    std::to_array<std::string_view>({"probe", "unknown", "simulated", "recording"});

constexpr std::string_view name_of(FrameOrigin origin) {
  return kFrameOriginNames[static_cast<std::size_t>(origin)];
}

/// nullopt for another name.
constexpr std::optional<FrameOrigin> frame_origin(std::string_view name) {
  const auto found = std::ranges::find(kFrameOriginNames, name);
  if (found == kFrameOriginNames.end()) return std::nullopt;
  return static_cast<FrameOrigin>(found - kFrameOriginNames.begin());
}

}  // namespace fanlight
