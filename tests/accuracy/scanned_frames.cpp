// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/scanned_frames.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace fanlight::test {

namespace {

const Scanner kScanners[] = {
    {"usual", {}},
    {"wide-range", {.range_db = 80, .tissue_grey = 200, .contrast_db = 50, .noise_db = -58}},
    {"broad-beam", {.contrast_db = 35, .axial_mm = 0.3, .lateral_mm = 0.9, .elevation_mm = 1.6}},
};

BeamAxes axes_at(const FanGeometry& geometry, double angle_rad, std::uint32_t column, std::uint32_t row) {
  const auto place = [&](double in_column, double in_row) {
    const PlanePoint at = geometry.plane_point({in_column, in_row});
    const Point point = geometry.point(at.x_mm, {.angle_rad = angle_rad, .depth_mm = at.depth_mm});
    return glm::dvec3(point.x_mm, point.y_mm, point.z_mm);
  };
  const glm::dvec3 here = place(column, row);
  const glm::dvec3 axial = glm::normalize(place(column, row + 1.0) - here);
  const glm::dvec3 lateral = glm::normalize(place(column + 1.0, row) - here);
  return {.axial = axial, .lateral = lateral, .elevation = glm::normalize(glm::cross(axial, lateral))};
}

/// A place in a frame.
struct Place {
  glm::dvec3 at{};
  BeamAxes axes;
  double depth_mm = 0;  ///< below the probe's face, along the scan line
};

Place place_in(const FanGeometry& geometry, double angle_rad, std::uint32_t column, std::uint32_t row) {
  const PlanePoint in_plane = geometry.plane_point({static_cast<double>(column), static_cast<double>(row)});
  const Point at = geometry.point(in_plane.x_mm, {.angle_rad = angle_rad, .depth_mm = in_plane.depth_mm});
  return {.at = {at.x_mm, at.y_mm, at.z_mm},
          .axes = axes_at(geometry, angle_rad, column, row),
          .depth_mm = geometry.polar() ? row * geometry.pixel_height_mm : in_plane.depth_mm};
}

/// Mean square of the share where side lobes point: at the same range, up to 8 deg aside in the frame and
/// 6 deg across it.
double beside(const Share& share, const Place& place) {
  const auto squared = [&](const glm::dvec3& towards, double angle_deg) {
    const double angle = radians(angle_deg);
    const glm::dvec3 at =
        place.at + place.depth_mm * (std::sin(angle) * towards + (std::cos(angle) - 1) * place.axes.axial);
    const double found = share(at, place.axes, place.depth_mm);
    return found * found;
  };
  double sum = 0;
  for (const double angle_deg : {-8.0, -4.0, 4.0, 8.0}) sum += squared(place.axes.lateral, angle_deg);
  for (const double angle_deg : {-6.0, 6.0}) sum += squared(place.axes.elevation, angle_deg);
  return sum / 6;
}

}  // namespace

std::span<const Scanner> scanners() {
  return kScanners;
}

Volume scanned(const TestFan& fan, const Share& share, const ScannerEcho& echo, const Grains& grains) {
  const FanGeometry& geometry = fan.geometry;
  return swept(fan, [&](std::uint32_t frame, double angle_rad, std::span<std::uint8_t> pixels) {
    for (std::uint32_t row = 0; row < geometry.rows; ++row) {
      double lobes = 0;
      for (std::uint32_t column = 0; column < geometry.columns; ++column) {
        const std::size_t pixel = std::size_t{row} * geometry.columns + column;
        const Place place = place_in(geometry, angle_rad, column, row);
        // They change slowly across the lines.
        if (column % 4 == 0) lobes = beside(share, place);
        const double level = echo.grey(share(place.at, place.axes, place.depth_mm), lobes, place.depth_mm,
                                       grains.speckle.frame(frame)[pixel], grains.noise.frame(frame)[pixel]);
        pixels[pixel] = static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
      }
    }
  });
}

Volume scanned(const TestFan& fan, const KnownSurface& surface, const ScannerEcho& echo,
               const Grains& grains) {
  return scanned(
      fan,
      [&](const glm::dvec3& at, const BeamAxes& axes, double depth_mm) {
        return echo.share(surface.below_mm(at), surface.normal(at), axes, depth_mm);
      },
      echo, grains);
}

}  // namespace fanlight::test
