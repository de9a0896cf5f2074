// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/womb_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "acquisition/phantom/phantom_options.hpp"
#include "tests/accuracy/phantom_truth.hpp"

namespace fanlight::test {

namespace {

using Part = BodyScene::Part;

bool is_fetus(Part part) {
  return part == Part::kHead || part == Part::kHand || part == Part::kCord;
}

}  // namespace

ScannedFan ScannedWomb::fan() const {
  const SourceDescription& description = source->description();
  return {.geometry = description.geometry,
          .first_angle_rad = description.first_angle_rad,
          .last_angle_rad = description.last_angle_rad};
}

ScannedWomb scanned_womb(std::string_view options) {
  auto config = parse_phantom(fmt::format("moving=off,{}", options), usual_phantom());
  if (!config) throw std::runtime_error(config.error().message);
  config->pace = PhantomSource::Pace::kUnpaced;
  auto source = made_phantom(*config);
  Volume volume = next_sweep(*source);
  return {.source = std::move(source), .volume = std::move(volume)};
}

bool Fetus::is_at(const glm::dvec3& point, double within_mm) const {
  const BodyScene::Found found = at(point);
  return is_fetus(found.part) && std::abs(found.distance_mm) <= within_mm;
}

std::optional<double> Fetus::met_mm(const PixelRay& ray, double from_mm, double to_mm) const {
  bool in_fluid = false;
  for (double depth_mm = from_mm; depth_mm < to_mm;) {
    const glm::dvec3 point = ray.at(depth_mm);
    const BodyScene::Found found = at(point);
    if (found.part != Part::kNearWall && found.distance_mm <= 0) {
      const bool meets = in_fluid && is_fetus(found.part) && is_scanned(point);
      return meets ? std::optional(depth_mm) : std::nullopt;
    }
    in_fluid |= found.distance_mm > 0;
    depth_mm += std::max(0.05, 0.6 * std::abs(static_cast<double>(found.distance_mm)));
  }
  return std::nullopt;
}

bool Fetus::is_scanned(const glm::dvec3& point) const {
  const FanCoordinate fan = geometry_.fan_coordinate(point.y, point.z);
  const FramePlace place = geometry_.frame_place({point.x, fan.depth_mm});
  return std::abs(fan.angle_rad) < source_.description().last_angle_rad && place.column > 1 &&
         place.column < geometry_.columns - 2 && place.row < geometry_.rows - 1;
}

}  // namespace fanlight::test
