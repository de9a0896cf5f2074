// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/scanned_frames.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

namespace fanlight::test {

namespace {

const Scanner kScanners[] = {
    {"usual", {}},
    {"wide-range", {.range_db = 80, .tissue_grey = 200, .contrast_db = 50, .noise_db = -58}},
    {"broad-beam", {.contrast_db = 35, .axial_mm = 0.3, .lateral_mm = 0.9, .elevation_mm = 1.6}},
};

/// A place in a frame.
struct Place {
  glm::dvec3 at{};
  BeamAxes axes;
  double depth_mm = 0;  ///< below the probe's face, along the scan line
};

/// Where the pixels of a frame lie in its plane; the same for all frames of a fan. Computed for each frame,
/// they would take a sine for each pixel.
class PixelPlaces {
 public:
  explicit PixelPlaces(const FanGeometry& geometry) : geometry_(geometry) {
    places_.reserve(std::size_t{geometry.rows + 1} * (geometry.columns + 1));
    for (std::uint32_t row = 0; row <= geometry.rows; ++row) {
      for (std::uint32_t column = 0; column <= geometry.columns; ++column)
        places_.push_back(geometry.plane_point({static_cast<double>(column), static_cast<double>(row)}));
    }
  }
  const PlanePoint& at(std::uint32_t column, std::uint32_t row) const {
    return places_[std::size_t{row} * (geometry_.columns + 1) + column];
  }
  double depth_mm(std::uint32_t column, std::uint32_t row) const {
    return geometry_.polar() ? row * geometry_.pixel_height_mm : at(column, row).depth_mm;
  }

 private:
  const FanGeometry& geometry_;
  std::vector<PlanePoint> places_;  // of one more row and column than pixels, for the axes of the last
};

/// The plane of a frame in space, which three of its points give.
class FramePlane {
 public:
  FramePlane(const FanGeometry& geometry, double angle_rad)
      : origin_(point(geometry, angle_rad, 0, 0)),
        across_(point(geometry, angle_rad, 1, 0) - origin_),
        down_(point(geometry, angle_rad, 0, 1) - origin_) {}

  Place place(const PixelPlaces& places, std::uint32_t column, std::uint32_t row) const {
    const glm::dvec3 here = at(places.at(column, row));
    const glm::dvec3 axial = glm::normalize(at(places.at(column, row + 1)) - here);
    const glm::dvec3 lateral = glm::normalize(at(places.at(column + 1, row)) - here);
    return {
        .at = here,
        .axes = {.axial = axial, .lateral = lateral, .elevation = glm::normalize(glm::cross(axial, lateral))},
        .depth_mm = places.depth_mm(column, row)};
  }

 private:
  static glm::dvec3 point(const FanGeometry& geometry, double angle_rad, double x_mm, double depth_mm) {
    const Point point = geometry.point(x_mm, {.angle_rad = angle_rad, .depth_mm = depth_mm});
    return {point.x_mm, point.y_mm, point.z_mm};
  }
  glm::dvec3 at(const PlanePoint& place) const {
    return origin_ + place.x_mm * across_ + place.depth_mm * down_;
  }

  glm::dvec3 origin_;
  glm::dvec3 across_;
  glm::dvec3 down_;
};

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
  const PixelPlaces places(geometry);
  return swept(fan, [&](std::uint32_t frame, double angle_rad, std::span<std::uint8_t> pixels) {
    const FramePlane plane(geometry, angle_rad);
    for (std::uint32_t row = 0; row < geometry.rows; ++row) {
      double lobes = 0;
      for (std::uint32_t column = 0; column < geometry.columns; ++column) {
        const std::size_t pixel = std::size_t{row} * geometry.columns + column;
        const Place place = plane.place(places, column, row);
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
        const double below_mm = surface.below_mm(at);
        // So far away the echo is that of fluid or of tissue, whatever the normal is, which is slow to find.
        const bool is_near = std::abs(below_mm) < 6 * echo.widest_mm(depth_mm) + 3.1 * echo.thickness_mm;
        return echo.share(below_mm, is_near ? surface.normal(at) : axes.axial, axes, depth_mm);
      },
      echo, grains);
}

}  // namespace fanlight::test
