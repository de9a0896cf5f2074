// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

/// Draws the scan lines of a curved array as a Cartesian frame, as a scanner does: linear interpolation
/// between the four nearest samples. Immutable after construction.
class ScanConverter {
 public:
  /// Scan lines from -half_angle_rad to half_angle_rad about the apex, with samples from the probe face on.
  struct Lines {
    std::uint32_t lines = 0;
    std::uint32_t samples = 0;  ///< of a line
    double half_angle_rad = 0;
    double step_mm = 0;
  };

  /// `to`: Cartesian, with a probe radius.
  ScanConverter(const Lines& from, const FanGeometry& to);

  /// `greys`: samples x lines, the first sample of each line first. `pixels`: rows x columns; 0 outside the
  /// sector.
  void draw(std::span<const std::uint8_t> greys, std::span<std::uint8_t> pixels) const;

 private:
  struct Source {
    std::uint32_t first = 0;   // of the four samples; kOutside: none
    std::uint16_t across = 0;  // shares of the next line and the next sample, 1 / 256
    std::uint16_t down = 0;
  };
  static constexpr std::uint32_t kOutside = ~0U;

  std::uint32_t lines_;
  std::vector<Source> sources_;  // a pixel
};

}  // namespace fanlight
