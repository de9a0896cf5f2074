// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/grid_padding.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace fanlight {

namespace {

constexpr double kLeastShare = 0.02;
// Echoes of a fan reach all sides of its grid; a body in fluid does not.
constexpr double kLeastExtent = 0.9;
// Thinner grids are nearly all border.
constexpr std::uint32_t kLeastSide = 8;
// Of the voxels between echoes, along any axis, and enclosed by them. A curved array leaves a dent before it.
constexpr double kMostDents = 0.1;
constexpr double kMostEnclosed = 0.01;
// A fan needs two or three. Voxels that are not reached then count as echoes.
constexpr int kMostSweeps = 64;

// A voxel of the value that no border has reached yet.
constexpr std::uint8_t kEchoes = 0;
constexpr std::uint8_t kReached = 1;
constexpr std::uint8_t kUnreached = 2;

class Voxels {
 public:
  Voxels(std::array<std::uint32_t, 3> size, std::vector<std::uint8_t> is_value)
      : size_{size[0], size[1], size[2]},
        step_{1, size_[0], size_[0] * size_[1]},
        state_(std::move(is_value)) {
    for (std::uint8_t& voxel : state_) voxel = voxel != 0 ? kUnreached : kEchoes;
  }

  /// Sweeps to and fro over all voxels, until none is reached any more.
  void reach_from_border() {
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      if (!sweep_once(sweep % 2 == 1) && sweep > 0) return;
    }
  }

  std::size_t count(std::uint8_t state) const {
    return static_cast<std::size_t>(std::ranges::count(state_, state));
  }

  /// The smallest part of a side of the grid that echoes reach over.
  double extent() const {
    double smallest = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::size_t first = size_[axis];
      std::size_t end = 0;
      for_each([&](std::size_t at, const std::array<std::size_t, 3>& place) {
        if (state_[at] != kEchoes) return;
        first = std::min(first, place[axis]);
        end = std::max(end, place[axis] + 1);
      });
      const double reach = end > first ? static_cast<double>(end - first) : 0;
      smallest = std::min(smallest, reach / static_cast<double>(size_[axis]));
    }
    return smallest;
  }

  /// Whether the padding is in all corners of the grid: a fan that is swept reaches none.
  bool has_all_corners() const {
    for (std::size_t corner = 0; corner < 8; ++corner) {
      std::size_t at = 0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        at += (corner >> axis & 1) * (size_[axis] - 1) * step_[axis];
      if (state_[at] != kReached) return false;
    }
    return true;
  }

  /// Reached voxels between two echoes along one of the axes; of the axis with the most.
  std::size_t dents() const {
    std::size_t most = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) most = std::max(most, dents_along(axis));
    return most;
  }

  std::vector<std::uint8_t> reached() && {
    for (std::uint8_t& voxel : state_) voxel = voxel == kReached ? 1 : 0;
    return std::move(state_);
  }

 private:
  template <typename Use>
  void for_each(Use&& use) const {
    std::size_t at = 0;
    for (std::size_t z = 0; z < size_[2]; ++z) {
      for (std::size_t y = 0; y < size_[1]; ++y) {
        for (std::size_t x = 0; x < size_[0]; ++x) use(at++, std::array{x, y, z});
      }
    }
  }

  bool is_on_border(const std::array<std::size_t, 3>& place) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (place[axis] == 0 || place[axis] + 1 == size_[axis]) return true;
    }
    return false;
  }

  /// Whether any voxel was reached.
  bool sweep_once(bool backward) {
    bool any = false;
    for_each([&](std::size_t forward_at, const std::array<std::size_t, 3>& forward_place) {
      const std::size_t at = backward ? state_.size() - 1 - forward_at : forward_at;
      if (state_[at] != kUnreached) return;
      // The place counted from the corner at which the sweep begins.
      bool is_reached = is_on_border(forward_place);
      for (std::size_t axis = 0; axis < 3 && !is_reached; ++axis)
        is_reached = state_[backward ? at + step_[axis] : at - step_[axis]] == kReached;
      if (!is_reached) return;
      state_[at] = kReached;
      any = true;
    });
    return any;
  }

  std::size_t dents_along(std::size_t axis) const {
    const std::size_t across = axis == 0 ? 1 : 0;
    const std::size_t down = axis == 2 ? 1 : 2;
    std::size_t dents = 0;
    for (std::size_t j = 0; j < size_[down]; ++j) {
      for (std::size_t i = 0; i < size_[across]; ++i) {
        const std::uint8_t* const line = &state_[i * step_[across] + j * step_[down]];
        const auto echoes = [&](std::size_t at) { return line[at * step_[axis]] == kEchoes; };
        std::size_t first = 0;
        std::size_t end = size_[axis];
        while (first < end && !echoes(first)) ++first;
        while (end > first && !echoes(end - 1)) --end;
        for (std::size_t at = first; at < end; ++at) dents += line[at * step_[axis]] == kReached ? 1 : 0;
      }
    }
    return dents;
  }

  std::array<std::size_t, 3> size_;
  std::array<std::size_t, 3> step_;
  std::vector<std::uint8_t> state_;
};

}  // namespace

GridPadding find_padding(std::array<std::uint32_t, 3> size, std::vector<std::uint8_t> is_value) {
  Voxels voxels(size, std::move(is_value));
  voxels.reach_from_border();
  const auto echoes = static_cast<double>(voxels.count(kEchoes));
  const auto reached = static_cast<double>(voxels.count(kReached));
  const auto enclosed = static_cast<double>(voxels.count(kUnreached));
  GridPadding padding{.share = reached / (reached + echoes + enclosed)};
  if (padding.share >= kLeastShare) {
    const bool is_border = std::ranges::min(size) >= kLeastSide && voxels.has_all_corners() &&
                           voxels.extent() >= kLeastExtent && enclosed <= kMostEnclosed * echoes &&
                           static_cast<double>(voxels.dents()) <= kMostDents * echoes;
    padding.look = is_border ? GridPadding::Look::kBorder : GridPadding::Look::kFluid;
  }
  padding.voxels = std::move(voxels).reached();
  return padding;
}

}  // namespace fanlight
