// SPDX-License-Identifier: Apache-2.0
#include "server/stream/stream_protocol.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace fanlight {

namespace {

// Version 1 had no roles: its clients would wait in vain for changes that the server refuses.
constexpr std::array<std::string_view, 1> kSupported = {"fanlight.v2"};

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

Result<std::string_view> agreed_protocol(std::string_view offered) {
  if (trimmed(offered).empty()) return std::string_view();
  for (std::string_view left = offered; !left.empty();) {
    const std::size_t comma = std::min(left.find(','), left.size());
    const auto supported = std::ranges::find(kSupported, trimmed(left.substr(0, comma)));
    if (supported != kSupported.end()) return *supported;
    left.remove_prefix(std::min(comma + 1, left.size()));
  }
  return Error{ErrorCode::kUnsupported, fmt::format("the client speaks {}, expected {}",
                                                    offered.substr(0, 128), fmt::join(kSupported, ", "))};
}

}  // namespace fanlight
