// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/test_fans.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <thread>

namespace fanlight::test {

namespace {

constexpr double kPixelMm = 0.3125;
constexpr double kMotorRadiusMm = 30;
constexpr double kProbeRadiusMm = 40;
constexpr int kFrames = 141;
constexpr double kFrameStepRad = kPixelMm / (kMotorRadiusMm + kSurfaceDepthMm);

FanGeometry flat_geometry(FrameKind kind) {
  return {.kind = kind,
          .columns = 176,
          .rows = 192,
          .pixel_width_mm = kPixelMm,
          .pixel_height_mm = kPixelMm,
          .face_column = 87.5,
          .face_row = 0,
          .motor_radius_mm = kMotorRadiusMm};
}

FanGeometry convex_geometry() {
  FanGeometry geometry = flat_geometry(FrameKind::kConvexLines);
  geometry.pixel_width_mm = 0;
  geometry.probe_radius_mm = kProbeRadiusMm;
  geometry.line_pitch_deg = degrees(kPixelMm / (kProbeRadiusMm + kSurfaceDepthMm));
  return geometry;
}

/// `share`: largest deviation of an angle from even spacing, as a fraction of the distance between frames.
std::vector<double> angles_rad(double share) {
  std::mt19937 bits(7);
  std::vector<double> angles;
  for (int frame = 0; frame < kFrames; ++frame) {
    const double uneven = share * (2 * static_cast<double>(bits()) / 0x1p32 - 1);
    angles.push_back(kFrameStepRad * (frame - (kFrames - 1) / 2.0 + uneven));
  }
  return angles;
}

Point in_body(const FanGeometry& geometry, double angle_rad, std::uint32_t column, std::uint32_t row) {
  const PlanePoint at = geometry.plane_point({static_cast<double>(column), static_cast<double>(row)});
  return geometry.point(at.x_mm, {.angle_rad = angle_rad, .depth_mm = at.depth_mm});
}

/// Draws the pixels of one frame. `factors`: of speckle, rows x columns; nullptr for none.
void draw(const FanGeometry& geometry, double angle_rad, const KnownSurface& surface, const KnownEcho& echo,
          const float* factors, std::span<std::uint8_t> pixels) {
  for (std::uint32_t row = 0; row < geometry.rows; ++row) {
    for (std::uint32_t column = 0; column < geometry.columns; ++column) {
      const std::size_t pixel = std::size_t{row} * geometry.columns + column;
      const Point at = in_body(geometry, angle_rad, column, row);
      const double below_mm = surface.below_mm({at.x_mm, at.y_mm, at.z_mm});
      const double grey = factors == nullptr ? echo.grey(below_mm) : echo.grey(below_mm, factors[pixel]);
      pixels[pixel] = static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
    }
  }
}

}  // namespace

ScannedFan TestFan::scanned() const {
  const auto [first, last] = std::ranges::minmax(angles_rad);
  return {.geometry = geometry, .first_angle_rad = first, .last_angle_rad = last};
}

std::vector<TestFan> test_fans() {
  std::vector<TestFan> fans = {
      {"cartesian", flat_geometry(FrameKind::kCartesian), angles_rad(0)},
      {"convex", convex_geometry(), angles_rad(0.2)},
      {"linear", flat_geometry(FrameKind::kLinearLines), angles_rad(0.2)},
  };
  std::ranges::reverse(fans.back().angles_rad);
  return fans;
}

std::vector<TestSurface> test_surfaces() {
  // Not aligned with the samples, so that no figure depends on a surface that lies on samples.
  const glm::dvec3 middle(0.07, kSurfaceDepthMm + 0.11, -0.05);
  const auto plane = [&](double about_x_deg, double about_z_deg) {
    return std::make_unique<KnownPlane>(middle, about_x_deg, about_z_deg);
  };
  std::vector<TestSurface> surfaces;
  surfaces.push_back({"plane", plane(0, 0)});
  surfaces.push_back({"plane-x20", plane(20, 0)});
  surfaces.push_back({"plane-x40", plane(40, 0)});
  surfaces.push_back({"plane-z20", plane(0, 20)});
  surfaces.push_back({"plane-z40", plane(0, 40)});
  surfaces.push_back({"plane-x30-z30", plane(30, 30)});
  surfaces.push_back({"sphere", std::make_unique<KnownSphere>(glm::dvec3(1.7, 50.3, -1.1), 19)});
  surfaces.push_back({"relief", std::make_unique<KnownRelief>(kSurfaceDepthMm)});
  return surfaces;
}

SpeckleField speckle_of(const TestFan& fan, std::uint64_t seed) {
  constexpr double kAlongMm = 0.5;
  constexpr double kAcrossMm = 1;
  constexpr double kElevationMm = 2;
  return SpeckleField(
      {.columns = fan.geometry.columns,
       .rows = fan.geometry.rows,
       .frames = static_cast<std::uint32_t>(fan.angles_rad.size())},
      {.columns = kAcrossMm / kPixelMm, .rows = kAlongMm / kPixelMm, .frames = kElevationMm / kPixelMm},
      seed);
}

Volume swept(const TestFan& fan, const DrawFrame& draw) {
  const auto frames = static_cast<std::uint32_t>(fan.angles_rad.size());
  Volume volume(fan.geometry, frames);
  std::vector<std::span<std::uint8_t>> pixels;
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    pixels.push_back(volume.next_frame_pixels());
    volume.add_frame({.sequence = frame, .frame_index = frame, .angle_rad = fan.angles_rad[frame]});
  }
  volume.sort_by_angle();
  volume.stamp().volume_id = 1;

  const auto draw_every = [&](std::uint32_t first, std::uint32_t step) {
    for (std::uint32_t place = first; place < frames; place += step) {
      const std::uint32_t frame = volume.by_angle()[place];
      draw(place, fan.angles_rad[frame], pixels[frame]);
    }
  };
  const std::uint32_t workers = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::jthread> threads;
  for (std::uint32_t worker = 0; worker < workers; ++worker)
    threads.emplace_back(draw_every, worker, workers);
  threads.clear();
  return volume;
}

Volume swept(const TestFan& fan, const KnownSurface& surface, const KnownEcho& echo,
             const SpeckleField* speckle) {
  return swept(fan, [&](std::uint32_t place, double angle_rad, std::span<std::uint8_t> pixels) {
    draw(fan.geometry, angle_rad, surface, echo, speckle == nullptr ? nullptr : speckle->frame(place),
         pixels);
  });
}

}  // namespace fanlight::test
