// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/near_tissue.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <iterator>
#include <limits>
#include <tuple>

#include "shaders/bindings.h"
#include "shaders/cast_parameters.h"

namespace fanlight {

namespace {

constexpr double kStepMm = 2;
constexpr int kHalvings = 6;
constexpr std::uint32_t kPoints = FANLIGHT_RAY_STARTS;
using Starts = std::array<std::optional<double>, std::size_t{kPoints} * kPoints>;

/// Rows from the end of near tissue to where rays start. The detector reads samples before its place: where
/// it looks for the end of what is bright, it would find the end of near tissue there. A bone lies next to
/// the end of what is before it.
double rows_to_start(const Scene& scene, double step_mm, const FanGeometry& geometry,
                     const NearTissueSearch& search) {
  if (scene.detector.sign != EdgeSign::kBrightToDark || search.ends_at_bone) return 0;
  return scene.detector.window / 2.0 * step_mm / geometry.pixel_height_mm;
}

/// Whether a point lies in the scanned fan, and before the end of the near tissue.
class Removed {
 public:
  enum class Place : std::uint8_t { kOutside, kRemoved, kShown };

  Removed(const FanGeometry& geometry, const VolumeExtent& volume, const NearTissue& near, double shift_rows)
      : geometry_(geometry), volume_(volume), near_(near), shift_rows_(shift_rows) {}

  Place place(const glm::dvec3& at) const {
    const FanCoordinate fan = geometry_.fan_coordinate(at.y, at.z);
    if (fan.angle_rad < volume_.first_angle_rad || fan.angle_rad > volume_.last_angle_rad)
      return Place::kOutside;
    const FramePlace in_frame = geometry_.frame_place({at.x, fan.depth_mm});
    if (!(in_frame.column >= 0 && in_frame.column <= geometry_.columns - 1 && in_frame.row >= 0 &&
          in_frame.row <= geometry_.rows - 1))
      return Place::kOutside;
    const double end_row = near_.end_row_at(geometry_, in_frame.column, fan.angle_rad) + shift_rows_;
    return in_frame.row < end_row ? Place::kRemoved : Place::kShown;
  }

 private:
  const FanGeometry& geometry_;
  const VolumeExtent& volume_;
  const NearTissue& near_;
  double shift_rows_;
};

/// A straight line: from + depth_mm * forward.
struct Line {
  glm::dvec3 from{};
  glm::dvec3 forward{};
};

/// Where a line first leaves what is removed, between two depths; first_mm where it enters the fan elsewhere.
/// nullopt: it never enters the fan.
std::optional<double> first_exit_mm(const Removed& removed, const Line& line, double first_mm,
                                    double last_mm) {
  using Place = Removed::Place;
  const auto place = [&](double depth_mm) { return removed.place(line.from + depth_mm * line.forward); };
  bool in_tissue = false;
  for (double depth_mm = first_mm; depth_mm <= last_mm; depth_mm += kStepMm) {
    const Place here = place(depth_mm);
    if (here == Place::kRemoved) in_tissue = true;
    if (here == Place::kRemoved || (here == Place::kOutside && !in_tissue)) continue;
    if (!in_tissue) return first_mm;
    double inside_mm = depth_mm - kStepMm;
    double outside_mm = depth_mm;
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle_mm = (inside_mm + outside_mm) / 2;
      (place(middle_mm) == Place::kRemoved ? inside_mm : outside_mm) = middle_mm;
    }
    return outside_mm;
  }
  return in_tissue ? std::optional<double>(last_mm) : std::nullopt;
}

/// Where the ray first leaves what is removed. nullopt: it never enters the fan.
std::optional<double> start_of(const Removed& removed, const shaders::CastParameters& rays, double column,
                               double row) {
  const Line ray{.from = glm::dvec3(rays.origin) + column * glm::dvec3(rays.right_step) +
                         row * glm::dvec3(rays.down_step),
                 .forward = glm::dvec3(rays.forward) + column * glm::dvec3(rays.right_turn) +
                            row * glm::dvec3(rays.down_turn)};
  return first_exit_mm(removed, ray, std::max(rays.start, rays.eye), rays.end);
}

/// Gives the points without a value the mean of their neighbours', from the nearest on.
void fill(Starts& starts) {
  for (bool any = true; any;) {
    any = false;
    const Starts before = starts;
    for (std::uint32_t at = 0; at < starts.size(); ++at) {
      if (before[at]) continue;
      double sum = 0;
      int count = 0;
      const auto add = [&](bool exists, std::uint32_t other) {
        if (!exists || !before[other]) return;
        sum += *before[other];
        ++count;
      };
      add(at % kPoints > 0, at - 1);
      add(at % kPoints + 1 < kPoints, at + 1);
      add(at >= kPoints, at - kPoints);
      add(at + kPoints < starts.size(), at + kPoints);
      if (count == 0) continue;
      starts[at] = sum / count;
      any = true;
    }
  }
}

}  // namespace

double NearTissue::end_row_at(const FanGeometry& geometry, double column, double angle_rad) const {
  const auto place = [](double share, std::uint32_t points) {
    return std::clamp(share, 0.0, 1.0) * (points - 1);
  };
  const double x = place(column / (geometry.columns - 1), kAcross);
  const double z = place((angle_rad - first_angle_rad) / (last_angle_rad - first_angle_rad), kAround);
  const auto left = std::min(static_cast<std::uint32_t>(x), kAcross - 2);
  const auto below = std::min(static_cast<std::uint32_t>(z), kAround - 2);
  const float* const from = &end_row[std::size_t{below} * kAcross + left];
  const float* const next = from + kAcross;
  return std::lerp(std::lerp(double{from[0]}, double{from[1]}, x - left),
                   std::lerp(double{next[0]}, double{next[1]}, x - left), z - below);
}

const NearTissue* NearTissueSearch::removed_by(const Scene::Near& near) const {
  const bool wanted = ends_at_bone ? near.before_bone == NearTissueShow::kRemoved : near.is_removed();
  return found && wanted ? &*found : nullptr;
}

NearTissueState NearTissueSearch::state(const Scene::Near& near) const {
  if (removed_by(near) != nullptr)
    return ends_at_bone ? NearTissueState::kRemovedToBone : NearTissueState::kRemoved;
  if (for_fluid && near.tissue == NearTissueShow::kRemoved) return NearTissueState::kNotFound;
  if (for_bone && near.before_bone == NearTissueShow::kRemoved) return NearTissueState::kNoBone;
  return NearTissueState::kShown;
}

shaders::NearTissueParameters near_tissue_parameters(const Scene& scene, const shaders::CastParameters& rays,
                                                     const FanGeometry& geometry, const VolumeExtent& volume,
                                                     const NearTissueSearch& search) {
  shaders::NearTissueParameters to{};
  std::ranges::fill(to.ray_start, static_cast<float>(-FANLIGHT_MAX_DEPTH));
  std::ranges::fill(to.end_row, static_cast<float>(-FANLIGHT_MAX_DEPTH));
  to.start_columns = static_cast<float>((kPoints - 1) / std::max(rays.width - 1.0, 1.0));
  to.start_rows = static_cast<float>((kPoints - 1) / std::max(rays.height - 1.0, 1.0));
  to.row_mm = static_cast<float>(geometry.pixel_height_mm);
  const NearTissue* const near = search.removed_by(scene.near);
  if (near == nullptr) return to;
  const double shift_rows = scene.near.shift_mm / geometry.pixel_height_mm;
  to.end_columns = static_cast<float>((NearTissue::kAcross - 1) / (geometry.columns - 1.0));
  to.end_angles =
      static_cast<float>((NearTissue::kAround - 1) / (near->last_angle_rad - near->first_angle_rad));
  to.end_first_angle = static_cast<float>(near->first_angle_rad);
  static_assert(std::size(decltype(to.end_row){}) == std::tuple_size_v<decltype(near->end_row)>);
  std::ranges::transform(near->end_row, to.end_row,
                         [&](float row) { return static_cast<float>(row + shift_rows); });

  const Removed removed(geometry, volume, *near,
                        shift_rows + rows_to_start(scene, rays.step, geometry, search));
  Starts starts;
  for (std::uint32_t row = 0; row < kPoints; ++row) {
    for (std::uint32_t column = 0; column < kPoints; ++column) {
      starts[row * kPoints + column] =
          start_of(removed, rays, double{1} * column / to.start_columns, double{1} * row / to.start_rows);
    }
  }
  fill(starts);
  for (std::size_t at = 0; at < starts.size(); ++at)
    if (starts[at]) to.ray_start[at] = static_cast<float>(*starts[at]);
  return to;
}

double near_end_mm(const Scene& scene, const FanGeometry& geometry, const VolumeExtent& volume,
                   const NearTissueSearch& search) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const NearTissue* const near = search.removed_by(scene.near);
  if (near == nullptr) return none;
  const Removed removed(geometry, volume, *near, scene.near.shift_mm / geometry.pixel_height_mm);
  const Line line{.from = {scene.camera.target.x_mm, 0, scene.camera.target.z_mm}, .forward = {0, 1, 0}};
  // Outside the fan at its rim, where it begins the nearest to the axis along y.
  const double rim_rad = std::max(std::abs(volume.first_angle_rad), std::abs(volume.last_angle_rad));
  const double first_mm = (geometry.nearest_mm() + geometry.motor_radius_mm) * std::cos(rim_rad) -
                          geometry.motor_radius_mm - kStepMm;
  const double last_mm = geometry.depth_mm();
  const auto end_mm = first_exit_mm(removed, line, first_mm, last_mm);
  return end_mm && *end_mm > first_mm && *end_mm < last_mm ? *end_mm : none;
}

}  // namespace fanlight
