// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/fan_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

// A hand that tilts a probe moves it by some millimetres too; beyond this the picture shows another body.
constexpr double kMostResidualMm = 6;
constexpr double kMostTurnDeg = 8;
constexpr double kLeastTiltDeg = 2;

struct Vector {
  double x = 0;
  double y = 0;
  double z = 0;

  Vector operator+(const Vector& b) const { return {x + b.x, y + b.y, z + b.z}; }
  Vector operator-(const Vector& b) const { return {x - b.x, y - b.y, z - b.z}; }
  Vector operator*(double factor) const { return {x * factor, y * factor, z * factor}; }
  double dot(const Vector& b) const { return x * b.x + y * b.y + z * b.z; }
  Vector cross(const Vector& b) const { return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x}; }
  double length() const { return std::sqrt(dot(*this)); }
  Vector unit() const { return *this * (1 / length()); }
};

struct Plane {
  Vector along;   ///< unit, along the rows
  Vector down;    ///< unit
  Vector origin;  ///< of row 0
};

Vector column(const ImagePose& pose, std::size_t at) {
  return {pose[at], pose[4 + at], pose[8 + at]};
}

Vector mean(std::span<const Plane> planes, Vector Plane::*member) {
  Vector sum;
  for (const Plane& plane : planes) sum = sum + plane.*member;
  return sum * (1 / static_cast<double>(planes.size()));
}

/// nullopt: the matrix is no rotation with pixel sizes and a place.
std::optional<Plane> plane_of(const ImagePose& pose, double centre_column) {
  const Vector along = column(pose, 0);
  const Vector down = column(pose, 1);
  const bool sized =
      along.length() > 1e-6 && down.length() > 1e-6 && along.length() < 1e6 && down.length() < 1e6;
  const bool finite = std::ranges::all_of(pose, [](double each) { return std::abs(each) < 1e9; });
  if (!sized || !finite || std::abs(along.unit().dot(down.unit())) > 0.01) return std::nullopt;
  return Plane{along.unit(), down.unit(), column(pose, 3) + along * centre_column};
}

Result<std::vector<Plane>> planes_of(std::span<const ImagePose> poses, double centre_column) {
  std::vector<Plane> planes;
  planes.reserve(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto plane = plane_of(poses[i], centre_column);
    if (!plane) {
      return Error{
          ErrorCode::kBadInput,
          fmt::format("the transform of frame {} is no pose, expected a rotation, pixel sizes and a place",
                      i)};
    }
    planes.push_back(*plane);
  }
  return planes;
}

double turn_rad(const Plane& plane, const Vector& axis) {
  return std::acos(std::clamp(axis.dot(plane.along), -1.0, 1.0));
}

Vector vector_of(const std::array<double, 3>& from) {
  return {from[0], from[1], from[2]};
}

/// The part of a vector that is perpendicular to the axis: a slide along it moves no image out of the fan.
Vector across_axis(const Vector& vector, const Vector& axis) {
  return vector - axis * axis.dot(vector);
}

/// The distance of the axis from row 0 along y.
double axis_of(std::span<const Plane> planes, const Vector& axis) {
  const Vector middle = mean(planes, &Plane::origin);
  const Vector down = mean(planes, &Plane::down);
  double together = 0;
  double alone = 0;
  for (const Plane& plane : planes) {
    const Vector apart = across_axis(plane.down - down, axis);
    together += apart.dot(across_axis(plane.origin - middle, axis));
    alone += apart.dot(apart);
  }
  return alone > 0 ? -together / alone : 0;
}

}  // namespace

Result<FanFit> fit_fan(std::span<const ImagePose> poses, double centre_column) {
  if (poses.size() < 3)
    return Error{ErrorCode::kBadInput,
                 fmt::format("{} frames have a pose, expected 3 at least", poses.size())};
  const auto found = planes_of(poses, centre_column);
  if (!found) return found.error();
  const std::vector<Plane>& planes = *found;
  const auto count = static_cast<double>(planes.size());
  const Vector axis = mean(planes, &Plane::along).unit();
  FanFit fit{.angles_rad = {}, .axis_mm = axis_of(planes, axis)};
  const Vector down = mean(planes, &Plane::down);
  const Vector middle_down = (down - axis * axis.dot(down)).unit();
  const Vector across = axis.cross(middle_down);
  Vector pivot;
  for (const Plane& plane : planes) pivot = pivot + (plane.origin + plane.down * fit.axis_mm) * (1 / count);
  double square_mm = 0;
  double square_slide = 0;
  double square_rad = 0;
  for (const Plane& plane : planes) {
    const Vector apart = plane.origin + plane.down * fit.axis_mm - pivot;
    const Vector across_mm = across_axis(apart, axis);
    square_mm += across_mm.dot(across_mm) / count;
    square_slide += axis.dot(apart) * axis.dot(apart) / count;
    square_rad += turn_rad(plane, axis) * turn_rad(plane, axis) / count;
    fit.angles_rad.push_back(std::atan2(plane.down.dot(across), plane.down.dot(middle_down)));
  }
  fit.residual_mm = std::sqrt(square_mm);
  fit.slide_mm = std::sqrt(square_slide);
  fit.turn_deg = degrees(std::sqrt(square_rad));
  const auto [smallest, largest] = std::ranges::minmax(fit.angles_rad);
  const double middle_rad = (smallest + largest) / 2;
  for (double& angle_rad : fit.angles_rad) angle_rad -= middle_rad;
  const Vector forward = middle_down * std::cos(middle_rad) + across * std::sin(middle_rad);
  fit.axis = {axis.x, axis.y, axis.z};
  fit.forward = {forward.x, forward.y, forward.z};
  fit.pivot_mm = {pivot.x, pivot.y, pivot.z};
  return fit;
}

std::optional<PlaceInFan> place_in_fan(const FanFit& fit, const ImagePose& pose, double centre_column) {
  const auto plane = plane_of(pose, centre_column);
  if (!plane) return std::nullopt;
  const Vector axis = vector_of(fit.axis);
  const Vector forward = vector_of(fit.forward);
  const Vector apart = plane->origin + plane->down * fit.axis_mm - vector_of(fit.pivot_mm);
  return PlaceInFan{
      .angle_rad = std::atan2(plane->down.dot(axis.cross(forward)), plane->down.dot(forward)),
      .miss_mm = across_axis(apart, axis).length(),
      .slide_mm = std::abs(axis.dot(apart)),
      .turn_deg = degrees(turn_rad(*plane, axis)),
  };
}

bool lies_in_fan(const PlaceInFan& place) {
  return place.miss_mm <= kMostResidualMm && place.slide_mm <= kMostResidualMm &&
         place.turn_deg <= kMostTurnDeg;
}

std::string why_no_fan(const FanFit& fit) {
  const auto [smallest, largest] = std::ranges::minmax(fit.angles_rad);
  const double tilt_deg = degrees(largest - smallest);
  if (tilt_deg < kLeastTiltDeg)
    return fmt::format("the frames tilt by {:.1f} deg only, expected {} at least", tilt_deg, kLeastTiltDeg);
  if (fit.residual_mm > kMostResidualMm) {
    return fmt::format("the best axis misses the frames by {:.1f} mm (root mean square), expected {} at most",
                       fit.residual_mm, kMostResidualMm);
  }
  if (fit.slide_mm > kMostResidualMm) {
    return fmt::format("the frames slide by {:.1f} mm along the axis (root mean square), expected {} at most",
                       fit.slide_mm, kMostResidualMm);
  }
  if (fit.turn_deg > kMostTurnDeg) {
    return fmt::format("the frames turn by {:.1f} deg (root mean square) out of the fan, expected {} at most",
                       fit.turn_deg, kMostTurnDeg);
  }
  return {};
}

}  // namespace fanlight
