// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// Quality reductions by which the deadline plan of a scene (deadline.plan) holds the picture rate.
struct DeadlineMeasures {
  bool coarse = false;         ///< one ray for 2 x 2 pixels
  bool wide_step = false;      ///< twice the distance between samples
  bool cheap_filters = false;  ///< no speckle filter; moving mean of depths; islands and holes are kept

  bool operator==(const DeadlineMeasures&) const = default;
};

/// Level of the deadline plan, 0 to kMostDeadlineLevel, and the measures in force.
struct DeadlineState {
  std::uint8_t level = 0;
  DeadlineMeasures measures;

  bool operator==(const DeadlineState&) const = default;
};

/// 1: coarse while the view moves; 2: always; 3: and a wide step; 4: and cheap filters.
inline constexpr std::uint8_t kMostDeadlineLevel = 4;

}  // namespace fanlight
