// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/wall_levels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace fanlight {

namespace {

constexpr double kAroundRegionMm = 4;      // thickness of what counts as wall
constexpr double kMeanOverMm = 1;          // of each mean
constexpr double kLeastLevelRatio = 0.35;  // of a direction's level to that of all
constexpr double kMostLevelRatio = 4;
constexpr std::size_t kDirections = 26;

struct Direction {
  float x = 0;
  float y = 0;
  float z = 0;
};

Direction unit(double x, double y, double z) {
  const double length = std::max(std::hypot(x, y, z), 1e-9);
  return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
}

/// To the sides, edges and corners of a cube.
const std::array<Direction, kDirections>& directions() {
  static const auto made = [] {
    std::array<Direction, kDirections> all{};
    std::size_t next = 0;
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
          if (x != 0 || y != 0 || z != 0) all[next++] = unit(x, y, z);
    return all;
  }();
  return made;
}

using Weights = std::array<float, kDirections>;

/// How much each direction counts for a place: falls to half within about 23 deg.
Weights weights_of(const Direction& towards) {
  Weights weights{};
  for (std::size_t index = 0; index < kDirections; ++index) {
    const Direction& each = directions()[index];
    const float cosine = std::max(0.0F, each.x * towards.x + each.y * towards.y + each.z * towards.z);
    const float squared = cosine * cosine;
    weights[index] = squared * squared * squared * squared;
  }
  return weights;
}

struct Mean {
  double sum = 0;
  double weight = 0;
  void add(double value, double by) {
    sum += by * value;
    weight += by;
  }
  double value() const { return weight > 0 ? sum / weight : 0; }
};

/// Means at equal distances.
using Profile = std::array<Mean, 4>;
static_assert(std::tuple_size_v<Profile> == kAroundRegionMm / kMeanOverMm);

double peak(const Profile& profile) {
  double most = 0;
  for (const Mean& mean : profile) most = std::max(most, mean.value());
  return most;
}

/// Where a region's cells lie in the mean.
struct Middle {
  double i = 0;
  double j = 0;
  double k = 0;

  Direction towards(const Cell& at) const { return unit(at.i - i, at.j - j, at.k - k); }
};

Middle middle_of(const CellBox& box, const Cells& region) {
  Middle middle;
  double cells = 0;
  for (std::size_t index = 0; index < region.size(); ++index) {
    if (region[index] == 0) continue;
    const Cell at = cell_of(box, index);
    middle.i += at.i;
    middle.j += at.j;
    middle.k += at.k;
    cells += 1;
  }
  if (cells > 0) middle = {middle.i / cells, middle.j / cells, middle.k / cells};
  return middle;
}

}  // namespace

double flatten_wall(EchoGrid& grid, const Cells& region) {
  const CellBox& box = grid.box;
  Cells outside(region.size());
  for (std::size_t index = 0; index < region.size(); ++index) outside[index] = region[index] == 0 ? 1 : 0;
  const auto most_steps = static_cast<std::uint32_t>(std::lround(kAroundRegionMm / box.step_mm)) + 1;
  const Cells steps = steps_within(box, outside, most_steps);
  const Middle middle = middle_of(box, region);
  Profile of_all{};
  std::array<Profile, kDirections> profiles{};
  for (std::size_t index = 0; index < steps.size(); ++index) {
    const double from_region_mm = (steps[index] - 0.5) * box.step_mm;
    if (steps[index] == 0 || from_region_mm >= kAroundRegionMm || grid.scanned[index] == 0) continue;
    const auto shell = static_cast<std::size_t>(from_region_mm / kMeanOverMm);
    const double level = grid.levels[index];
    of_all[shell].add(level, 1);
    const Weights weights = weights_of(middle.towards(cell_of(box, index)));
    for (std::size_t direction = 0; direction < kDirections; ++direction)
      profiles[direction][shell].add(level, weights[direction]);
  }
  const double all = peak(of_all);
  if (all <= 0) return 0;
  std::array<float, kDirections> levels{};
  for (std::size_t direction = 0; direction < kDirections; ++direction)
    levels[direction] = static_cast<float>(
        std::clamp(peak(profiles[direction]), kLeastLevelRatio * all, kMostLevelRatio * all));
  const auto flat = static_cast<float>(1 / all);
  for (std::size_t index = 0; index < grid.levels.size(); ++index) {
    const bool is_near = region[index] != 0 || (steps[index] > 0 && steps[index] < most_steps);
    if (!is_near) {
      grid.levels[index] *= flat;
      continue;
    }
    const Weights weights = weights_of(middle.towards(cell_of(box, index)));
    float sum = 0;
    float weight = 0;
    for (std::size_t direction = 0; direction < kDirections; ++direction) {
      sum += weights[direction] * levels[direction];
      weight += weights[direction];
    }
    grid.levels[index] *= sum > 0 ? weight / sum : flat;  // in the middle itself there is no direction
  }
  return all;
}

}  // namespace fanlight
