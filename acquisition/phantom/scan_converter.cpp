// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/scan_converter.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight {

ScanConverter::ScanConverter(const Lines& from, const FanGeometry& to) : lines_(from.lines) {
  sources_.reserve(std::size_t{to.rows} * to.columns);
  for (std::uint32_t row = 0; row < to.rows; ++row) {
    for (std::uint32_t column = 0; column < to.columns; ++column) {
      const PlanePoint at = to.plane_point({static_cast<double>(column), static_cast<double>(row)});
      const double ahead_mm = at.depth_mm + to.probe_radius_mm;
      const double beyond = (std::hypot(at.x_mm, ahead_mm) - to.probe_radius_mm) / from.step_mm;
      // A line's last sample stands for its whole step.
      const double sample = beyond < from.samples ? std::min(beyond, from.samples - 1.0) : beyond;
      const double line = (std::atan2(at.x_mm, ahead_mm) / from.half_angle_rad + 1) / 2 * (from.lines - 1);
      const bool inside = line >= 0 && line <= from.lines - 1 && sample >= 0 && sample <= from.samples - 1;
      if (!inside) {
        sources_.push_back({.first = kOutside});
        continue;
      }
      const auto first_line = std::min(static_cast<std::uint32_t>(line), from.lines - 2);
      const auto first_sample = std::min(static_cast<std::uint32_t>(sample), from.samples - 2);
      sources_.push_back({.first = first_sample * from.lines + first_line,
                          .across = static_cast<std::uint16_t>(std::lround(256 * (line - first_line))),
                          .down = static_cast<std::uint16_t>(std::lround(256 * (sample - first_sample)))});
    }
  }
}

void ScanConverter::draw(std::span<const std::uint8_t> greys, std::span<std::uint8_t> pixels) const {
  const std::uint8_t* const from = greys.data();
  std::ranges::transform(sources_, pixels.begin(), [&](const Source& source) {
    if (source.first == kOutside) return std::uint8_t{0};
    const std::uint8_t* const near = from + source.first;
    const std::uint8_t* const far = near + lines_;
    const std::uint32_t above = 256U * near[0] + source.across * (near[1] - near[0]);
    const std::uint32_t below = 256U * far[0] + source.across * (far[1] - far[0]);
    return static_cast<std::uint8_t>((above * (256U - source.down) + below * source.down + (1U << 15)) >> 16);
  });
}

}  // namespace fanlight
