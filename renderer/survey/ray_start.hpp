// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace fanlight {

/// Where a search along one ray may start to find a sheet first: from a depth up to another one, mm.
struct StartRange {
  double from_mm = 0;  ///< behind the last echo before the sheet; -HUGE_VAL: there is none
  double to_mm = 0;    ///< the sheet; beyond from_mm
};

/// A depth from which a search finds the sheet first in this number of rays.
struct Start {
  double depth_mm = 0;
  std::size_t found = 0;
};

/// Parts finer than what the ranges know, such as a nose, may lie so far before the sheet, mm: where nothing
/// else lies there, the search starts before them.
inline constexpr double kFinePartsMm = 12;

/// The smallest depth that lies in almost as many ranges as the best one does, but no more than kFinePartsMm
/// before the nearest end of those. Without ranges: 0, found in none.
Start best_start(const std::vector<StartRange>& ranges);

}  // namespace fanlight
