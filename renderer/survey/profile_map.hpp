// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "proto/model/volume.hpp"
#include "renderer/parameters/near_tissue.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

/// A smooth map over the fan: a place along each profile, in cells with a fraction.
class ProfileMap {
 public:
  /// `profiles` must outlive this. Precondition: at least two profiles across, and two frames.
  explicit ProfileMap(const VolumeProfiles& profiles);

  void set(std::uint32_t profile, double cell);

  /// Gives the profiles that were not set the mean of their neighbours, from the nearest on. Precondition:
  /// one is set.
  void fill();

  /// Means over the neighbours, each held by `limited(profile, cell)`.
  template <typename Limit>
  void smooth(int rounds, const Limit& limited) {
    for (int round = 0; round < rounds; ++round) {
      const std::vector<double> before = cells_;
      for (std::uint32_t profile = 0; profile < cells_.size(); ++profile)
        cells_[profile] = limited(profile, mean_around(before, profile));
    }
  }

  /// Resampled. nullopt: all frames have one angle.
  std::optional<NearTissue> near_tissue(const Volume& volume) const;

  /// Calls use(other, weight) for each profile at most `reach` away, with itself, which counts twice.
  template <typename Use>
  void for_neighbours(std::uint32_t profile, int reach, Use&& use) const {
    const int across = static_cast<int>(profiles_.across());
    const int frames = static_cast<int>(profiles_.frames());
    const int column = static_cast<int>(profile) % across;
    const int frame = static_cast<int>(profile) / across;
    for (int z = std::max(0, frame - reach); z <= std::min(frames - 1, frame + reach); ++z) {
      for (int x = std::max(0, column - reach); x <= std::min(across - 1, column + reach); ++x)
        use(static_cast<std::uint32_t>(z * across + x), z == frame && x == column ? 2.0 : 1.0);
    }
  }

 private:
  double mean_around(const std::vector<double>& cells, std::uint32_t profile) const;
  double at(double across, double angle_rad) const;
  double frame_at(double angle_rad) const;

  const VolumeProfiles& profiles_;
  std::vector<double> cells_;
  std::vector<bool> known_;
};

}  // namespace fanlight
