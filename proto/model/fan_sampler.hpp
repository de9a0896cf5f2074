// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// Reads a volume between its samples: linearly between the two frames around an angle, bilinearly in each.
/// Reading allocates nothing. Any thread.
class FanSampler {
 public:
  /// `volume` must outlive this object and have at least two frames.
  explicit FanSampler(const Volume& volume);

  /// Pixels of the two frames around an angle, and the share of the second, 0 to 1.
  struct Between {
    std::span<const std::uint8_t> first;
    std::span<const std::uint8_t> second;
    double share = 0;
  };
  /// nullopt beyond the outermost frames.
  std::optional<Between> around(double angle_rad) const;

  /// The echo at a point of the plane of a frame, 0 to 255; nullopt where nothing was scanned. Of Cartesian
  /// frames without a known sector, 0 may be either.
  std::optional<double> echo(const Between& frames, const PlanePoint& point) const;

  /// The same as a grey level of 1 or more, or 0 where nothing was scanned.
  std::uint8_t at(const Between& frames, const PlanePoint& point) const;

 private:
  bool has_zero(std::span<const std::uint8_t> pixels, std::size_t index) const;

  const Volume& volume_;
  const FanGeometry& geometry_;
  bool knows_border_;
  std::vector<double> angles_rad_;  // ascending
};

}  // namespace fanlight
