// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/depth_truth.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

namespace fanlight::test {

namespace {

/// Depth at which a ray enters the fan; nullopt if it misses the fan, or possibly if it crosses less than 2
/// mm of it.
std::optional<double> fan_entry_mm(const PixelRay& ray, const ScannedFan& fan, double from_mm, double to_mm) {
  constexpr double kStepMm = 2;
  double outside_mm = from_mm;
  double inside_mm = from_mm;
  while (!fan.holds(ray.at(inside_mm))) {
    outside_mm = inside_mm;
    inside_mm += kStepMm;
    if (inside_mm > to_mm) return std::nullopt;
  }
  for (int halving = 0; halving < 12; ++halving) {
    const double middle_mm = (outside_mm + inside_mm) / 2;
    (fan.holds(ray.at(middle_mm)) ? inside_mm : outside_mm) = middle_mm;
  }
  return inside_mm;
}

double incidence_deg(const PixelRay& ray, const glm::dvec3& normal) {
  return degrees(std::acos(std::clamp(-glm::dot(glm::normalize(ray.direction), normal), -1.0, 1.0)));
}

PixelTruth truth_of(const PixelRay& ray, double from_mm, double to_mm, const ScannedFan& fan,
                    const KnownSurface& surface) {
  const auto fan_mm = fan_entry_mm(ray, fan, from_mm, to_mm);
  if (!fan_mm) return {};
  // Starts slightly before the fan, so that a surface at its border is included.
  constexpr double kBeforeMm = 1;
  constexpr double kPastMm = 0.01;
  for (auto entry_mm = surface.entry_mm(ray, *fan_mm - kBeforeMm, to_mm); entry_mm;
       entry_mm = surface.entry_mm(ray, *entry_mm + kPastMm, to_mm)) {
    const glm::dvec3 at = ray.at(*entry_mm);
    if (!fan.holds(at)) continue;
    return {.meets = fan.holds_ball(at, kBorderMm) ? Meets::kSurface : Meets::kBorder,
            .depth_mm = *entry_mm,
            .incidence_deg = incidence_deg(ray, surface.normal(at))};
  }
  const bool in_tissue = surface.below_mm(ray.at(*fan_mm)) > 0;
  return {.meets = in_tissue ? Meets::kTissueFirst : Meets::kFluid};
}

}  // namespace

std::vector<PixelTruth> depth_truth(const PixelRays& rays, PictureSize size, const ScannedFan& fan,
                                    const KnownSurface& surface) {
  std::vector<PixelTruth> truth;
  truth.reserve(std::size_t{size.width} * size.height);
  for (std::uint32_t row = 0; row < size.height; ++row) {
    for (std::uint32_t column = 0; column < size.width; ++column) {
      truth.push_back(truth_of(rays.ray(column, row), rays.first_mm(), rays.last_mm(), fan, surface));
    }
  }
  return truth;
}

}  // namespace fanlight::test
