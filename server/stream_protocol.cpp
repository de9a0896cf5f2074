#include "server/stream_protocol.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace fanlight {

namespace {

// Version 1 had no roles: what speaks it would wait in vain for its changes to be taken.
constexpr std::array<std::string_view, 1> kSpoken = {"fanlight.v2"};

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
    const auto spoken = std::ranges::find(kSpoken, trimmed(left.substr(0, comma)));
    if (spoken != kSpoken.end()) return *spoken;
    left.remove_prefix(std::min(comma + 1, left.size()));
  }
  return Error{ErrorCode::kUnsupported, fmt::format("the client speaks {}, expected {}",
                                                    offered.substr(0, 128), fmt::join(kSpoken, ", "))};
}

}  // namespace fanlight
