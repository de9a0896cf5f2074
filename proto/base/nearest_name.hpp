// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fanlight {

/// The name among `known` that a person most likely meant by `typed`: with the fewest letters changed, left
/// out, added or exchanged with their neighbour, at most a third of them, or one. Empty: none is near.
std::string nearest_name(std::string_view typed, const std::vector<std::string>& known);

}  // namespace fanlight
