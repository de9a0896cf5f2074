// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fanlight {

/// The name among `known` that a person most likely meant by `typed`, as a text for people: with the fewest
/// letters changed, left out, added or exchanged with their neighbour, at most a third of them, or one. Names
/// whose last part was typed, detector.threshold for threshold, come before those with other letters; where
/// they are several, all of them: "filter.kind or light.kind". Empty: none is near.
std::string nearest_name(std::string_view typed, const std::vector<std::string>& known);

}  // namespace fanlight
