// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/ray_start.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight {

Start best_start(const std::vector<StartRange>& ranges) {
  constexpr double kAlmost = 0.99;
  if (ranges.empty()) return {};
  std::vector<double> begins;
  std::vector<double> ends;
  for (const StartRange& range : ranges) {
    begins.push_back(range.from_mm);
    ends.push_back(range.to_mm);
  }
  std::ranges::sort(begins);
  std::ranges::sort(ends);
  // Each range begins before it ends. The count changes at the ends only; at one it is the largest since the
  // end before: those that have begun, without those that have ended.
  const auto count_at = [&](std::size_t end) {
    const auto begun = std::ranges::lower_bound(begins, ends[end]) - begins.begin();
    return static_cast<std::size_t>(begun) - end;
  };
  Start best;
  for (std::size_t end = 0; end < ends.size(); ++end) best.found = std::max(best.found, count_at(end));
  const auto enough = static_cast<std::size_t>(std::ceil(kAlmost * static_cast<double>(best.found)));
  std::size_t first = 0;
  while (count_at(first) < enough) ++first;
  // So many have to begin before it.
  best.depth_mm = std::max(ends[first] - kFinePartsMm, begins[enough + first - 1]);
  return best;
}

}  // namespace fanlight
