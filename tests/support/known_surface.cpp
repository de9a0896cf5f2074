// SPDX-License-Identifier: Apache-2.0
#include "tests/support/known_surface.hpp"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace fanlight::test {

namespace {

/// Depth between two depths of a ray at which below_mm() changes sign, to well under a micrometre.
double bisected_mm(const KnownSurface& surface, const PixelRay& ray, double above_mm, double below_mm) {
  for (int halving = 0; halving < 30; ++halving) {
    const double middle_mm = (above_mm + below_mm) / 2;
    (surface.below_mm(ray.at(middle_mm)) > 0 ? below_mm : above_mm) = middle_mm;
  }
  return below_mm;
}

std::optional<double> if_between(double depth_mm, double from_mm, double to_mm) {
  return depth_mm >= from_mm && depth_mm <= to_mm ? std::optional(depth_mm) : std::nullopt;
}

}  // namespace

std::optional<double> KnownSurface::entry_mm(const PixelRay& ray, double from_mm, double to_mm) const {
  // The step is small against the radius of curvature of every surface in this file.
  constexpr double kStepMm = 0.25;
  bool in_fluid = below_mm(ray.at(from_mm)) <= 0;
  for (double depth_mm = from_mm; depth_mm < to_mm; depth_mm += kStepMm) {
    const double next_mm = std::min(depth_mm + kStepMm, to_mm);
    const bool next_in_fluid = below_mm(ray.at(next_mm)) <= 0;
    if (in_fluid && !next_in_fluid) return bisected_mm(*this, ray, depth_mm, next_mm);
    in_fluid = next_in_fluid;
  }
  return std::nullopt;
}

glm::dvec3 KnownSurface::normal(const glm::dvec3& at) const {
  const double offset_mm = normal_offset_mm();
  glm::dvec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 offset(0);
    offset[axis] = offset_mm;
    gradient[axis] = below_mm(at + offset) - below_mm(at - offset);
  }
  return -glm::normalize(gradient);
}

double KnownEcho::grey(double below_mm) const {
  if (thickness_mm > 0) {
    const double from_middle = (below_mm - thickness_mm / 2) / thickness_mm;
    return fluid_grey + contrast() * std::exp2(-4 * from_middle * from_middle);
  }
  const double tissue_fraction = 0.5 * std::erfc(-below_mm / (spread_mm * std::numbers::sqrt2));
  return fluid_grey + contrast() * tissue_fraction;
}

double KnownEcho::grey(double below_mm, double factor) const {
  const double mean = grey(below_mm);
  if (range_db == 0) return mean * factor;
  return mean + 255 / range_db * 20 * std::log10(std::max(factor, 1e-3));
}

KnownPlane::KnownPlane(const glm::dvec3& through, double about_x_deg, double about_z_deg)
    : through_(through),
      inwards_(-std::sin(radians(about_z_deg)) * std::cos(radians(about_x_deg)),
               std::cos(radians(about_z_deg)) * std::cos(radians(about_x_deg)),
               std::sin(radians(about_x_deg))) {}

double KnownPlane::below_mm(const glm::dvec3& at) const {
  return glm::dot(at - through_, inwards_);
}

std::optional<double> KnownPlane::entry_mm(const PixelRay& ray, double from_mm, double to_mm) const {
  const double inwards_per_mm = glm::dot(ray.direction, inwards_);
  if (inwards_per_mm <= 0) return std::nullopt;
  return if_between(-below_mm(ray.origin) / inwards_per_mm, from_mm, to_mm);
}

double KnownSphere::below_mm(const glm::dvec3& at) const {
  return radius_mm_ - glm::distance(at, centre_);
}

std::optional<double> KnownSphere::entry_mm(const PixelRay& ray, double from_mm, double to_mm) const {
  const glm::dvec3 from_centre = ray.origin - centre_;
  const double a = glm::dot(ray.direction, ray.direction);
  const double half_b = glm::dot(ray.direction, from_centre);
  const double c = glm::dot(from_centre, from_centre) - radius_mm_ * radius_mm_;
  const double discriminant = half_b * half_b - a * c;
  if (discriminant <= 0) return std::nullopt;
  return if_between((-half_b - std::sqrt(discriminant)) / a, from_mm, to_mm);
}

double KnownRelief::below_mm(const glm::dvec3& at) const {
  constexpr double kHeightMm = 2;
  constexpr double kAlongX = 2 * kPi / 27;  // rad per mm
  constexpr double kAlongZ = 2 * kPi / 22;
  constexpr double kSlope = 0.15;  // so that no crest of a wave is perpendicular to the probe's axis
  const double x = kAlongX * at.x + 0.6;
  const double z = kAlongZ * at.z - 0.4;
  const double surface_mm = mean_depth_mm_ + kHeightMm * (std::sin(x) + std::sin(z)) + kSlope * at.x;
  const double by_x = kHeightMm * kAlongX * std::cos(x) + kSlope;
  const double by_z = kHeightMm * kAlongZ * std::cos(z);
  return (at.y - surface_mm) / std::sqrt(1 + by_x * by_x + by_z * by_z);
}

}  // namespace fanlight::test
