// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/twin_map.hpp"

namespace fanlight::test {

namespace {

using glm::dvec2;
using glm::dvec3;

double linear_of(double displayed) {
  return displayed <= 0.04045 ? displayed / 12.92 : std::pow((displayed + 0.055) / 1.055, 2.4);
}

double displayed_of(double linear) {
  const double bounded = std::clamp(linear, 0.0, 1.0);
  return bounded <= 0.0031308 ? 12.92 * bounded : 1.055 * std::pow(bounded, 1 / 2.4) - 0.055;
}

/// The depth map as a height map in the view frame, mm: right, up, height towards the viewer (-depth).
class Relief {
 public:
  Relief(const std::vector<double>& depth_mm, PictureSize size, const Scene& scene)
      : scene_(scene), part_(viewport(scene, size)), map_(depth_mm, size, part_) {}

  const TwinMap& map() const { return map_; }
  bool perspective() const { return scene_.camera.projection == Projection::kPerspective; }

  /// Perspective: height of the eye above the view plane.
  double eye_mm() const { return eye_distance_mm(scene_.camera) - scene_.camera.distance_mm; }

  /// Distance between pixels at a depth / distance between pixels at the target.
  double scale(double depth_mm) const {
    return perspective() ? (depth_mm + eye_mm()) / eye_distance_mm(scene_.camera) : 1;
  }

  dvec3 point(int column, int row, double depth_mm) const {
    const double apart_mm = part_.pixel_mm * scale(depth_mm);
    return {(column - part_.centre_column()) * apart_mm, (part_.centre_row() - row) * apart_mm, -depth_mm};
  }
  dvec3 point(int column, int row) const { return point(column, row, map_.depth(column, row)); }

  /// The inverse: column and row at which a point is seen.
  dvec2 pixel(const dvec3& point) const {
    const double apart_mm = part_.pixel_mm * scale(-point.z);
    return {part_.centre_column() + point.x / apart_mm, part_.centre_row() - point.y / apart_mm};
  }

  dvec3 normal(int column, int row) const {
    return glm::normalize(glm::cross(tangent(column, row, 1, 0), -tangent(column, row, 0, 1)));
  }

  dvec3 to_viewer(const dvec3& point) const {
    return perspective() ? glm::normalize(dvec3(0, 0, eye_mm()) - point) : dvec3(0, 0, 1);
  }

  /// Fraction of the light visible from a pixel, 0 to 1 (`light_seen` in light.comp).
  double visibility(int column, int row) const;

 private:
  /// The tangent of the surface in a direction of the picture, in columns and rows.
  dvec3 tangent(int column, int row, int right, int down) const {
    const dvec3 here = point(column, row);
    const bool central = scene_.light.normals == Normals::kCentral;
    const auto joined = [&](int x, int y) {
      const double apart_mm = std::abs(map_.depth(x, y) - map_.depth(column, row));
      return map_.surface(x, y) && (!central || apart_mm <= scene_.filter.step_mm);
    };
    const bool next = joined(column + right, row + down);
    const bool before = joined(column - right, row - down);
    if (central && next && before) {
      return point(column + right, row + down) - point(column - right, row - down);
    }
    if (next) return point(column + right, row + down) - here;
    if (before) return here - point(column - right, row - down);
    return point(column + right, row + down, map_.depth(column, row)) - here;
  }

  const Scene& scene_;
  Viewport part_;
  TwinMap map_;
};

dvec3 light_position(const Scene::Light& light) {
  return {light.right_mm, light.up_mm, -light.depth_mm};
}

/// The vector from the target to the position of a directional light.
dvec3 to_directional_light(const Scene& scene) {
  return light_position(scene.light) - dvec3(0, 0, -scene.camera.distance_mm);
}

dvec3 light_direction(const Scene& scene) {
  const dvec3 to_light = to_directional_light(scene);
  return glm::length(to_light) > 0 ? glm::normalize(to_light) : dvec3(0, 0, 1);
}

double Relief::visibility(int column, int row) const {
  constexpr double kFarMm = 1000;
  constexpr double kBiasPixels = 1.5;
  const bool point_light = scene_.light.kind == LightKind::kPoint;
  const dvec3 surface = point(column, row);
  const dvec3 to_light =
      point_light ? light_position(scene_.light) - surface : kFarMm * light_direction(scene_);
  const double light_distance_mm =
      std::max(glm::length(point_light ? to_light : to_directional_light(scene_)), 1e-3);

  // The shadow ray: from just above the surface to the light, or to the upper limit of the heights.
  const dvec3 from = surface + dvec3(0, 0, kBiasPixels * part_.pixel_mm * scale(map_.depth(column, row)));
  dvec3 to = from + to_light;
  const double top = -(perspective() ? std::max(scene_.rays.start_mm, 1 - eye_mm()) : scene_.rays.start_mm);
  if (to.z > top) {
    if (from.z >= top) return 1;
    to = from + (to - from) * ((top - from.z) / (to.z - from.z));
  }

  const dvec2 first = pixel(from);
  const dvec2 last = pixel(to);
  const double pixels = std::max(std::abs(last.x - first.x), std::abs(last.y - first.y));
  double visible = 1;
  for (int pixel_step = 1; pixel_step < pixels; ++pixel_step) {
    const double fraction = pixel_step / pixels;
    const dvec2 at = first + fraction * (last - first);
    if (at.x < part_.left || at.x > part_.left + part_.width - 1.0 || at.y < part_.top ||
        at.y > part_.top + part_.height - 1.0) {
      break;
    }
    // In perspective, equal steps in the picture are not equal steps in the body.
    const double near = fraction * scale(-from.z);
    const double along = near / (near + (1 - fraction) * scale(-to.z));
    const double depth_mm =
        map_.depth(static_cast<int>(std::floor(at.x + 0.5)), static_cast<int>(std::floor(at.y + 0.5)));
    if (depth_mm < 0) continue;
    const double clearance_mm = from.z + along * (to.z - from.z) + depth_mm;
    if (scene_.shadow.softness_mm == 0) {
      if (clearance_mm < 0) return 0;
    } else {
      const double spread_mm = scene_.shadow.softness_mm * along * glm::length(to - from) / light_distance_mm;
      visible = std::min(visible, std::clamp(0.5 + 0.5 * clearance_mm / spread_mm, 0.0, 1.0));
    }
  }
  return visible;
}

/// Blinn-Phong.
Rgb lit_colour(const Scene& scene, const Relief& relief, int column, int row) {
  const Scene::Light& light = scene.light;
  const dvec3 point = relief.point(column, row);
  const dvec3 normal = relief.normal(column, row);
  const dvec3 to_light = light.kind == LightKind::kPoint ? glm::normalize(light_position(light) - point)
                                                         : light_direction(scene);
  const dvec3 halfway = glm::normalize(to_light + relief.to_viewer(point));
  const double facing = std::max(glm::dot(normal, to_light), 0.0);
  const double highlight =
      facing > 0 ? std::pow(std::max(glm::dot(normal, halfway), 0.0), light.shininess) : 0;
  const bool shades = facing > 0 && scene.shadow.coefficient < 1;
  const double direct = shades ? std::lerp(scene.shadow.coefficient, 1.0, relief.visibility(column, row)) : 1;

  const dvec3 lamp(linear_of(light.red), linear_of(light.green), linear_of(light.blue));
  const dvec3 material(linear_of(scene.material.red), linear_of(scene.material.green),
                       linear_of(scene.material.blue));
  const dvec3 linear = lamp * (material * light.ambient +
                               direct * (material * light.diffuse * facing + light.specular * highlight));
  return {displayed_of(linear.x), displayed_of(linear.y), displayed_of(linear.z)};
}

/// The depth map as grey: near is bright.
Rgb depth_grey(const Scene::Rays& rays, double depth_mm) {
  return Rgb(std::clamp(1 - (depth_mm - rays.start_mm) / (rays.end_mm - rays.start_mm), 0.0, 1.0));
}

bool shows_surface(Mode mode) {
  return mode == Mode::kSurface || mode == Mode::kSurfaceAndVolume || mode == Mode::kSlices ||
         mode == Mode::kDepth;
}

}  // namespace

std::vector<Rgb> twin_light(const std::vector<double>& smooth_mm, const std::vector<Rgb>& colour,
                            PictureSize size, const Scene& scene) {
  if (!shows_surface(scene.mode)) return colour;
  std::vector<Rgb> shown = scene.mode == Mode::kSlices ? colour : std::vector(smooth_mm.size(), Rgb(0));
  const Relief relief(smooth_mm, size, scene);
  relief.map().for_each([&](int column, int row) {
    const std::size_t pixel = relief.map().index(column, row);
    if (!relief.map().surface(column, row)) {
      shown[pixel] = Rgb(0);
    } else if (scene.mode == Mode::kDepth) {
      shown[pixel] = depth_grey(scene.rays, smooth_mm[pixel]);
    } else {
      shown[pixel] = lit_colour(scene, relief, column, row);
    }
  });
  if (scene.mode == Mode::kSurfaceAndVolume) {
    // The volume is to the right of the surface. With an odd width one black column remains.
    const std::size_t half = size.width / 2;
    for (std::size_t row = 0; row < size.height; ++row) {
      for (std::size_t column = 0; column < half; ++column) {
        shown[row * size.width + half + column] = colour[row * size.width + column];
      }
    }
  }
  return shown;
}

}  // namespace fanlight::test
