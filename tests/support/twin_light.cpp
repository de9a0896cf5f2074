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

/// The depth map as a surface in the view frame: right, up, height (towards the viewer, -depth), mm.
class Relief {
 public:
  Relief(const std::vector<double>& depth_mm, PictureSize size, const Scene& scene)
      : scene_(scene), part_(viewport(scene, size)), map_(depth_mm, size, part_) {}

  const TwinMap& map() const { return map_; }
  bool perspective() const { return scene_.camera.projection == Projection::kPerspective; }

  /// Of the eye above the view plane, in perspective.
  double eye_mm() const { return eye_distance_mm(scene_.camera) - scene_.camera.distance_mm; }

  /// How far pixels lie apart at a depth, over how far they do at the target's.
  double scale(double depth_mm) const {
    return perspective() ? (depth_mm + eye_mm()) / eye_distance_mm(scene_.camera) : 1;
  }

  dvec3 place(int column, int row, double depth_mm) const {
    const double apart_mm = part_.pixel_mm * scale(depth_mm);
    return {(column - part_.centre_column()) * apart_mm, (part_.centre_row() - row) * apart_mm, -depth_mm};
  }
  dvec3 place(int column, int row) const { return place(column, row, map_.depth(column, row)); }

  /// Column and row in which a place shows: the inverse.
  dvec2 pixel(const dvec3& place) const {
    const double apart_mm = part_.pixel_mm * scale(-place.z);
    return {part_.centre_column() + place.x / apart_mm, part_.centre_row() - place.y / apart_mm};
  }

  dvec3 normal(int column, int row) const {
    return glm::normalize(glm::cross(tangent(column, row, 1, 0), -tangent(column, row, 0, 1)));
  }

  dvec3 to_viewer(const dvec3& place) const {
    return perspective() ? glm::normalize(dvec3(0, 0, eye_mm()) - place) : dvec3(0, 0, 1);
  }

  /// Share of the lamp that shows from a pixel, 0 to 1.
  double visibility(int column, int row) const;

 private:
  /// Along the surface to the next pixel in a direction, in columns and rows.
  dvec3 tangent(int column, int row, int right, int down) const {
    const dvec3 here = place(column, row);
    const bool central = scene_.light.normals == Normals::kCentral;
    const auto joined = [&](int x, int y) {
      const double apart_mm = std::abs(map_.depth(x, y) - map_.depth(column, row));
      return map_.surface(x, y) && (!central || apart_mm <= scene_.filter.step_mm);
    };
    const bool next = joined(column + right, row + down);
    const bool before = joined(column - right, row - down);
    if (central && next && before) {
      return place(column + right, row + down) - place(column - right, row - down);
    }
    if (next) return place(column + right, row + down) - here;
    if (before) return here - place(column - right, row - down);
    return place(column + right, row + down, map_.depth(column, row)) - here;
  }

  const Scene& scene_;
  Viewport part_;
  TwinMap map_;
};

dvec3 lamp_place(const Scene::Light& light) {
  return {light.right_mm, light.up_mm, -light.depth_mm};
}

/// From where to the target a directional light shines.
dvec3 lamp_way(const Scene& scene) {
  return lamp_place(scene.light) - dvec3(0, 0, -scene.camera.distance_mm);
}

dvec3 lamp_direction(const Scene& scene) {
  const dvec3 way = lamp_way(scene);
  return glm::length(way) > 0 ? glm::normalize(way) : dvec3(0, 0, 1);
}

double Relief::visibility(int column, int row) const {
  constexpr double kFarMm = 1000;
  constexpr double kBiasPixels = 1.5;
  const bool point = scene_.light.kind == LightKind::kPoint;
  const dvec3 surface = place(column, row);
  const dvec3 way = point ? lamp_place(scene_.light) - surface : kFarMm * lamp_direction(scene_);
  const double lamp_mm = std::max(glm::length(point ? way : lamp_way(scene_)), 1e-3);

  // The walk: from just above the surface to the light, or to where nothing can lie any higher.
  const dvec3 from = surface + dvec3(0, 0, kBiasPixels * part_.pixel_mm * scale(map_.depth(column, row)));
  dvec3 to = from + way;
  const double top = -(perspective() ? std::max(scene_.rays.start_mm, 1 - eye_mm()) : scene_.rays.start_mm);
  if (to.z > top) {
    if (from.z >= top) return 1;
    to = from + (to - from) * ((top - from.z) / (to.z - from.z));
  }

  const dvec2 first = pixel(from);
  const dvec2 last = pixel(to);
  const double pixels = std::max(std::abs(last.x - first.x), std::abs(last.y - first.y));
  double visible = 1;
  for (int walked = 1; walked < pixels; ++walked) {
    const double share = walked / pixels;
    const dvec2 at = first + share * (last - first);
    if (at.x < part_.left || at.x > part_.left + part_.width - 1.0 || at.y < part_.top ||
        at.y > part_.top + part_.height - 1.0) {
      break;
    }
    // The share of the way in space that this share of the pixels is.
    const double near = share * scale(-from.z);
    const double gone = near / (near + (1 - share) * scale(-to.z));
    const double depth_mm =
        map_.depth(static_cast<int>(std::floor(at.x + 0.5)), static_cast<int>(std::floor(at.y + 0.5)));
    if (depth_mm < 0) continue;
    const double clearance_mm = from.z + gone * (to.z - from.z) + depth_mm;
    if (scene_.shadow.softness_mm == 0) {
      if (clearance_mm < 0) return 0;
    } else {
      const double spread_mm = scene_.shadow.softness_mm * gone * glm::length(to - from) / lamp_mm;
      visible = std::min(visible, std::clamp(0.5 + 0.5 * clearance_mm / spread_mm, 0.0, 1.0));
    }
  }
  return visible;
}

/// Blinn-Phong.
Rgb lit_colour(const Scene& scene, const Relief& relief, int column, int row) {
  const Scene::Light& light = scene.light;
  const dvec3 place = relief.place(column, row);
  const dvec3 normal = relief.normal(column, row);
  const dvec3 to_light =
      light.kind == LightKind::kPoint ? glm::normalize(lamp_place(light) - place) : lamp_direction(scene);
  const dvec3 halfway = glm::normalize(to_light + relief.to_viewer(place));
  const double facing = std::max(glm::dot(normal, to_light), 0.0);
  const double gleam = facing > 0 ? std::pow(std::max(glm::dot(normal, halfway), 0.0), light.shininess) : 0;
  const bool shades = facing > 0 && scene.shadow.coefficient < 1;
  const double direct = shades ? std::lerp(scene.shadow.coefficient, 1.0, relief.visibility(column, row)) : 1;

  const dvec3 lamp(linear_of(light.red), linear_of(light.green), linear_of(light.blue));
  const dvec3 skin(linear_of(scene.material.red), linear_of(scene.material.green),
                   linear_of(scene.material.blue));
  const dvec3 linear =
      lamp * (skin * light.ambient + direct * (skin * light.diffuse * facing + light.specular * gleam));
  return {displayed_of(linear.x), displayed_of(linear.y), displayed_of(linear.z)};
}

/// Bright is near.
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
    // The volume stands to the right of the surface; with an odd width a black column is left.
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
