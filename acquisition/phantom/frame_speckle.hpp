// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/phantom/speckle_tile.hpp"

namespace fanlight {

/// Speckle of the frames of a sweep, Rayleigh distributed factors of mean 1.
///
/// The scatterers of a sweep lie in slices one frame distance apart, each an excerpt of the tile. A frame's
/// echo is their complex sum, weighted by the beam's thickness across the frame: where the beam is thicker
/// than the distance of the frames, as near the probe, neighbouring frames show nearly the same speckle;
/// a beam thicker than kMostDeviation counts as that. Another sweep has other scatterers: in the time
/// between, a patient and a hand move by more than a wavelength.
///
/// One thread; allocates nothing after construction.
class FrameSpeckle {
 public:
  static constexpr std::uint32_t kOne = 64;  ///< the factor 1; factors are limited just below 4
  /// A thicker beam's speckle is that of this one: standard deviation of its power, in frame distances.
  static constexpr float kMostDeviation = 1.5F;

  /// Without speckle: all factors are kOne.
  explicit FrameSpeckle(std::uint32_t columns);
  /// `deviations`: of each row, the standard deviation of the beam's power across the frame, in frame
  /// distances.
  FrameSpeckle(std::uint64_t seed, std::uint32_t columns, std::vector<float> deviations);

  /// A frame's sweep, and its place on the fan in frame distances.
  struct Place {
    std::uint64_t sweep = 0;
    double frame = 0;
  };
  /// What row() gives from now on.
  void set_place(const Place& place);

  /// The factors of a row, one a column; valid until the next call.
  std::span<const std::uint8_t> row(std::uint32_t row);

 private:
  static constexpr int kReach = 4;  // slices to either side of the nearest
  struct Slice {
    std::uint32_t row = 0;  // in the tile
    std::uint32_t column = 0;
    float away = 0;  // from the frame, in frame distances
  };

  void add(const Slice& slice, std::uint32_t row, float weight);

  std::optional<SpeckleTile> tile_;
  std::uint64_t seed_ = 0;
  std::vector<float> deviations_;
  std::array<Slice, 2 * kReach + 1> slices_{};
  std::vector<float> real_;  // of a row
  std::vector<float> imaginary_;
  std::vector<std::uint8_t> factors_;
};

}  // namespace fanlight
