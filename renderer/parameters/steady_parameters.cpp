// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/steady_parameters.hpp"

#include <algorithm>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <string_view>

#include "renderer/parameters/view_frame.hpp"

namespace fanlight {

namespace {

// Fewer pixels have too much noise for a mean to say anything of motion.
constexpr int kLeastCellSide = 4;

glm::dvec3 vector_of(const std::array<double, 3>& values) {
  return {values[0], values[1], values[2]};
}

shaders::MapView map_view(const MapPlace& place) {
  const SurfacePart& part = place.view.part;
  const auto across = static_cast<int>(part.width);
  const auto down = static_cast<int>(part.height);
  const int side =
      std::max(kLeastCellSide, (std::max(across, down) + FANLIGHT_MAP_CELLS - 1) / FANLIGHT_MAP_CELLS);
  return {.width = place.size.width,
          .left = static_cast<int>(part.left),
          .top = static_cast<int>(part.top),
          .right = static_cast<int>(part.left) + across - 1,
          .bottom = static_cast<int>(part.top) + down - 1,
          .middle = {place.view.middle_column, place.view.middle_row},
          .scale_at_0 = static_cast<float>(place.view.mm_per_pixel),
          .scale_per_mm = static_cast<float>(place.view.mm_per_pixel_per_mm),
          .cell_side = side,
          .cells_across = (across + side - 1) / side,
          .cells_down = (down + side - 1) / side};
}

/// Whether all fields whose names begin so are equal.
bool are_equal(const Scene& first, const Scene& second, std::initializer_list<std::string_view> names) {
  return std::ranges::all_of(scene_fields(), [&](const SceneField& field) {
    const bool counts =
        std::ranges::any_of(names, [&](std::string_view name) { return field.name.starts_with(name); });
    return !counts || field.same(first, second);
  });
}

}  // namespace

bool finds_same_surface(const Scene& first, const Scene& second) {
  return are_equal(first, second, {"detector.", "speckle.", "near.", "rays.step_mm", "rays.window"});
}

bool differs_in_view_alone(const Scene& first, const Scene& second) {
  return finds_same_surface(first, second) && first.size == second.size &&
         are_equal(first, second, {"rays.", "crop.", "cuts.", "clip1.", "clip2."});
}

std::optional<EarlierMap> earlier_map(const Scene& mapped, PictureSize usual, const Scene& scene,
                                      bool has_volume) {
  if (!finds_same_surface(mapped, scene)) return std::nullopt;
  const PictureSize size = size_of(mapped, usual);
  return EarlierMap{.place = {.view = picture_view(mapped, size), .size = size}, .has_volume = has_volume};
}

shaders::SteadyParameters steady_parameters(const MapPlace& now, const EarlierMap& earlier,
                                            double target_depth_mm, double share) {
  const PictureView& from = earlier.place.view;
  const glm::dvec3 right = vector_of(from.right);
  const glm::dvec3 down = vector_of(from.down);
  const glm::dvec3 forward = vector_of(from.forward);
  const auto in_earlier = [&](const glm::dvec3& vector) {
    return glm::dvec3(glm::dot(vector, right), glm::dot(vector, down), glm::dot(vector, forward));
  };
  const glm::dvec3 origin = in_earlier(vector_of(now.view.origin_mm) - vector_of(from.origin_mm));
  const glm::dvec3 ahead = in_earlier(vector_of(now.view.forward));
  return {.now = map_view(now),
          .earlier = map_view(earlier.place),
          .right = in_earlier(vector_of(now.view.right)),
          .down = in_earlier(vector_of(now.view.down)),
          .forward = ahead,
          .origin = origin,
          .pivot = origin + target_depth_mm * ahead,
          .added_volumes = earlier.has_volume ? 0.0F : 1.0F,
          .most_volumes = static_cast<float>(1 / (1 - share))};
}

}  // namespace fanlight
