// SPDX-License-Identifier: Apache-2.0
#include "tests/support/scanner_echo.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace fanlight::test {

namespace {

double amplitude_of(double decibel) {
  return std::pow(10, decibel / 20);
}

}  // namespace

double ScannerEcho::spread_mm(const glm::dvec3& normal, const BeamAxes& axes, double depth_mm) const {
  const double wider_mm = widening * (depth_mm - focus_mm);
  const double along = axial_mm * glm::dot(normal, axes.axial);
  const double across = std::hypot(lateral_mm, wider_mm) * glm::dot(normal, axes.lateral);
  const double elevation = std::hypot(elevation_mm, wider_mm) * glm::dot(normal, axes.elevation);
  return std::sqrt(along * along + across * across + elevation * elevation);
}

double ScannerEcho::widest_mm(double depth_mm) const {
  return std::max(axial_mm, std::hypot(std::max(lateral_mm, elevation_mm), widening * (depth_mm - focus_mm)));
}

double ScannerEcho::share(double below_mm, const glm::dvec3& normal, const BeamAxes& axes,
                          double depth_mm) const {
  const double spread = spread_mm(normal, axes, depth_mm);
  if (is_diffuse && thickness_mm == 0) return std::sqrt(0.5 * std::erfc(-below_mm / spread));
  if (thickness_mm == 0) return 0.5 * std::erfc(-below_mm / (spread * std::numbers::sqrt2));
  // A Gaussian sheet stays one, lower and wider.
  const double sheet = thickness_mm / (2 * std::sqrt(2 * std::numbers::ln2));
  const double blurred = std::hypot(sheet, spread);
  const double away = (below_mm - thickness_mm / 2) / blurred;
  return sheet / blurred * std::exp(-0.5 * away * away);
}

double ScannerEcho::grey(double share, double beside, double depth_mm, double factor, double noise) const {
  const double fluid = amplitude_of(-contrast_db);
  const double lobes = amplitude_of(lobes_db) * std::sqrt(beside);
  const double reverberation =
      amplitude_of(reverberation_db - reverberation_db_per_mm * std::max(depth_mm, 0.0));
  const double echo = std::hypot(fluid + (1 - fluid) * share, lobes, reverberation) * factor;
  const double amplitude = std::hypot(echo, amplitude_of(noise_db) * noise);
  return tissue_grey + 255 / range_db * 20 * std::log10(std::max(amplitude, 1e-6));
}

}  // namespace fanlight::test
