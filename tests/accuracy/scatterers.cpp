// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/scatterers.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace fanlight::test {

namespace {

constexpr double kWaveMm = 0.44;  // 3.5 MHz in tissue
constexpr double kPerMm3 = 6;
constexpr double kReach = 2.5;  // standard deviations of the beam

/// A scatterer as the probe meets it.
struct Met {
  double frame = 0;  // in order of angle
  double column = 0;
  double row = 0;
  double depth_mm = 0;  // below the probe's face, along the line
  float amplitude = 0;
};

}  // namespace

Scatterers::Scatterers(const TestFan& fan, const KnownSurface& surface, std::uint64_t seed) : fan_(fan) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<float> amplitude;
  const FanGeometry& geometry = fan.geometry;
  const ScannedFan bounds = fan.scanned();
  const double most_mm = geometry.depth_mm();
  const double across_mm = geometry.right_mm() - geometry.left_mm();
  const double along_mm = 2 * (geometry.motor_radius_mm + most_mm) *
                          std::sin(std::max(-bounds.first_angle_rad, bounds.last_angle_rad));
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11U) * 0x1p-53;
  };
  const auto count = static_cast<std::size_t>(kPerMm3 * across_mm * along_mm * most_mm);
  for (std::size_t each = 0; each < count; ++each) {
    const glm::dvec3 at(between(geometry.left_mm(), geometry.right_mm()), between(0, most_mm),
                        between(-along_mm / 2, along_mm / 2));
    const float strength = amplitude(bits);
    if (surface.below_mm(at) > 0) scatterers_.push_back({at, strength});
  }
}

Volume Scatterers::scanned(const Move& move, const ScannerEcho& echo, const SpeckleField& noise) const {
  const FanGeometry& geometry = fan_.geometry;
  const auto frames = static_cast<double>(fan_.angles_rad.size());
  const ScannedFan bounds = fan_.scanned();
  const double frame_rad = (bounds.last_angle_rad - bounds.first_angle_rad) / (frames - 1);
  std::vector<std::vector<Met>> by_frame(fan_.angles_rad.size());
  for (const Scatterer& scatterer : scatterers_) {
    const glm::dvec3 at = move(scatterer.at);
    const FanCoordinate fan = geometry.fan_coordinate(at.y, at.z);
    const FramePlace place = geometry.frame_place({.x_mm = at.x, .depth_mm = fan.depth_mm});
    const double frame = (fan.angle_rad - bounds.first_angle_rad) / frame_rad;
    const auto bin = std::clamp(std::lround(frame), 0L, static_cast<long>(frames) - 1);
    by_frame[static_cast<std::size_t>(bin)].push_back({.frame = frame,
                                                       .column = place.column,
                                                       .row = place.row,
                                                       .depth_mm = place.row * geometry.pixel_height_mm,
                                                       .amplitude = scatterer.amplitude});
  }

  const auto draw = [&](std::uint32_t frame, double /*angle_rad*/, std::span<std::uint8_t> pixels) {
    std::vector<std::complex<float>> field(pixels.size());
    double powers = 0;
    const auto frames_apart = static_cast<int>(std::ceil(
        kReach * echo.elevation_mm / (frame_rad * (geometry.motor_radius_mm + kSurfaceDepthMm / 2))));
    for (int other = -frames_apart; other <= frames_apart; ++other) {
      const int bin = static_cast<int>(frame) + other;
      if (bin < 0 || bin >= static_cast<int>(frames)) continue;
      for (const Met& met : by_frame[static_cast<std::size_t>(bin)]) {
        const double wider_mm = echo.widening * (met.depth_mm - echo.focus_mm);
        const double elevation_mm = std::hypot(echo.elevation_mm, wider_mm);
        const double aside_mm =
            (met.frame - frame) * frame_rad * (geometry.motor_radius_mm + met.depth_mm) / elevation_mm;
        if (std::abs(aside_mm) > kReach) continue;
        const double lateral_mm = std::hypot(echo.lateral_mm, wider_mm);
        const double column_mm = radians(geometry.line_pitch_deg) * (geometry.probe_radius_mm + met.depth_mm);
        const auto wave = std::polar(1.0F, static_cast<float>(4 * std::numbers::pi / kWaveMm * met.depth_mm));
        const auto strength = wave * met.amplitude * static_cast<float>(std::exp(-0.5 * aside_mm * aside_mm));
        const double columns = kReach * lateral_mm / column_mm;
        const double rows = kReach * echo.axial_mm / geometry.pixel_height_mm;
        const auto first_column = static_cast<int>(std::max(std::ceil(met.column - columns), 0.0));
        const auto last_column =
            static_cast<int>(std::min(std::floor(met.column + columns), geometry.columns - 1.0));
        const auto first_row = static_cast<int>(std::max(std::ceil(met.row - rows), 0.0));
        const auto last_row = static_cast<int>(std::min(std::floor(met.row + rows), geometry.rows - 1.0));
        for (int row = first_row; row <= last_row; ++row) {
          const double along = (row - met.row) * geometry.pixel_height_mm / echo.axial_mm;
          const auto of_row = strength * static_cast<float>(std::exp(-0.5 * along * along));
          for (int column = first_column; column <= last_column; ++column) {
            const double across = (column - met.column) * column_mm / lateral_mm;
            field[static_cast<std::size_t>(row) * geometry.columns + static_cast<std::size_t>(column)] +=
                of_row * static_cast<float>(std::exp(-0.5 * across * across));
          }
        }
      }
    }
    // The mean power of tissue: scatterers of unit variance, over the beam's square.
    powers = kPerMm3 * std::pow(std::numbers::pi, 1.5) * echo.axial_mm * echo.lateral_mm * echo.elevation_mm;
    for (std::uint32_t row = 0; row < geometry.rows; ++row) {
      for (std::uint32_t column = 0; column < geometry.columns; ++column) {
        const std::size_t pixel = std::size_t{row} * geometry.columns + column;
        // Rayleigh factors of mean 1 in full tissue, as speckle is elsewhere.
        const double share = std::abs(field[pixel]) / std::sqrt(powers * std::numbers::pi / 4);
        const double level =
            echo.grey(share, 0, row * geometry.pixel_height_mm, 1, noise.frame(frame)[pixel]);
        pixels[pixel] = static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
      }
    }
  };
  return swept(fan_, draw);
}

}  // namespace fanlight::test
