// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <memory>
#include <utility>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/twin_layers.hpp"
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
  /// Upper limit of the heights of surfaces.
  double top_mm() const {
    return -(perspective() ? std::max(scene_.rays.start_mm, 1 - eye_mm()) : scene_.rays.start_mm);
  }

  double pixel_mm() const { return part_.pixel_mm; }
  double pixel_mm(double depth_mm) const { return part_.pixel_mm * scale(depth_mm); }
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

  /// Fraction of a light visible from a pixel, 0 to 1 (`light_seen` in surface_light.h).
  double visibility(int column, int row, const Scene::Lamp& lamp) const;

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

/// The lights that are on: the key light, the fill light, the back light.
std::vector<Scene::Lamp> lamps_of(const Scene& scene) {
  const Scene::Light& light = scene.light;
  const Scene::Lamp key{light.on,  light.right_mm, light.up_mm, light.depth_mm,
                        light.red, light.green,    light.blue,  light.strength};
  std::vector<Scene::Lamp> lamps{key, scene.fill_light, scene.back_light};
  std::erase_if(lamps,
                [](const Scene::Lamp& lamp) { return lamp.on == LightSwitch::kOff || lamp.strength == 0; });
  return lamps;
}

dvec3 light_position(const Scene::Lamp& lamp) {
  return {lamp.right_mm, lamp.up_mm, -lamp.depth_mm};
}

/// The vector from the target to the position of a directional light.
dvec3 to_directional_light(const Scene& scene, const Scene::Lamp& lamp) {
  return light_position(lamp) - dvec3(0, 0, -scene.camera.distance_mm);
}

dvec3 light_direction(const Scene& scene, const Scene::Lamp& lamp) {
  const dvec3 to_light = to_directional_light(scene, lamp);
  return glm::length(to_light) > 0 ? glm::normalize(to_light) : dvec3(0, 0, 1);
}

double Relief::visibility(int column, int row, const Scene::Lamp& lamp) const {
  constexpr double kFarMm = 1000;
  constexpr double kBiasPixels = 1.5;
  const bool point_light = scene_.light.kind == LightKind::kPoint;
  const dvec3 surface = point(column, row);
  const dvec3 to_light =
      point_light ? light_position(lamp) - surface : kFarMm * light_direction(scene_, lamp);
  const double light_distance_mm =
      std::max(glm::length(point_light ? to_light : to_directional_light(scene_, lamp)), 1e-3);

  // The shadow ray: from just above the surface to the light, or to the upper limit of the heights.
  const dvec3 from = surface + dvec3(0, 0, kBiasPixels * part_.pixel_mm * scale(map_.depth(column, row)));
  dvec3 to = from + to_light;
  const double top = top_mm();
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

dvec3 to_light_from(const Scene& scene, const Scene::Lamp& lamp, const dvec3& point) {
  return scene.light.kind == LightKind::kPoint ? glm::normalize(light_position(lamp) - point)
                                               : light_direction(scene, lamp);
}

/// What a shadow leaves of the direct light.
double direct_light(const Scene& scene, const Scene::Lamp& lamp, const Relief& relief, int column, int row,
                    double cosine) {
  const bool shades = cosine > 0 && scene.shadow.coefficient < 1;
  return shades ? std::lerp(scene.shadow.coefficient, 1.0, relief.visibility(column, row, lamp)) : 1;
}

constexpr int kAround = 12;
constexpr dvec2 kSpiral[kAround] = {{0.204, 0.0},     {-0.261, 0.239}, {0.040, -0.455}, {0.328, 0.429},
                                    {-0.603, -0.107}, {0.571, -0.363}, {-0.190, 0.711}, {-0.366, -0.700},
                                    {0.789, 0.286},   {-0.822, 0.335}, {0.397, -0.847}, {0.285, 0.937}};

/// How much of the light a surface keeps near a border without a surface beyond (`known_around` in
/// soft_light.comp).
double known_around(const Scene& scene, const Relief& relief, int column, int row) {
  if (scene.light.fade_mm <= 0) return 1;
  const double pixels = scene.light.fade_mm / relief.pixel_mm(relief.map().depth(column, row));
  int points = 0;
  int known = 0;
  for (const dvec2& place : kSpiral) {
    const int x = column + static_cast<int>(std::floor(pixels * place.x + 0.5));
    const int y = row + static_cast<int>(std::floor(pixels * place.y + 0.5));
    points += relief.map().inside(x, y) ? 1 : 0;
    known += relief.map().surface(x, y) ? 1 : 0;
  }
  return points > 0 ? std::clamp(2.0 * known / points - 1, 0.0, 1.0) : 1;
}

/// Share of the ambient light that arrives in a hollow (`sky_seen` in soft_light.comp).
double sky_seen(const Scene& scene, const Relief& relief, int column, int row, const dvec3& normal) {
  const double reach_mm = scene.light.occlusion_mm;
  const dvec3 here = relief.point(column, row);
  const double pixels = reach_mm / relief.pixel_mm(-here.z);
  double hidden = 0;
  for (const dvec2& place : kSpiral) {
    const int x = column + static_cast<int>(std::floor(pixels * place.x + 0.5));
    const int y = row + static_cast<int>(std::floor(pixels * place.y + 0.5));
    if (!relief.map().surface(x, y)) continue;
    const dvec3 away = relief.point(x, y) - here;
    const double apart_mm = std::max(glm::length(away), 1e-3);
    const double near = std::max(1 - apart_mm * apart_mm / (reach_mm * reach_mm), 0.0);
    hidden += near * std::max(glm::dot(away, normal) / apart_mm - 0.08, 0.0);
  }
  return std::clamp(1 - 3 * hidden / kAround, 0.0, 1.0);
}

/// Share of the light that comes through the body (`light_through` in soft_light.comp).
double light_through(const Scene& scene, const Scene::Lamp& lamp, const Relief& relief, const dvec3& here,
                     const dvec3& to_light) {
  const double reach_mm = 2 * scene.material.scatter_mm;
  const double step_mm = reach_mm / 4;
  const double light_mm = scene.light.kind == LightKind::kPoint ? glm::length(light_position(lamp) - here)
                                                                : std::numeric_limits<double>::infinity();
  double thickness_mm = 0;
  for (double along_mm = step_mm / 2; along_mm < std::min(24 * step_mm, light_mm); along_mm += step_mm) {
    const dvec3 there = here + along_mm * to_light;
    if (there.z > relief.top_mm()) break;
    const dvec2 pixel = relief.pixel(there);
    const int column = static_cast<int>(std::floor(pixel.x + 0.5));
    const int row = static_cast<int>(std::floor(pixel.y + 0.5));
    if (!relief.map().surface(column, row)) continue;
    const double clearance_mm = there.z + relief.map().depth(column, row);
    thickness_mm += step_mm * std::clamp(0.5 - clearance_mm / step_mm, 0.0, 1.0);
  }
  return std::exp(-thickness_mm / reach_mm);
}

/// The light of soft_light.comp and scatter.comp, of each of the lights that are on.
class SoftLight {
 public:
  struct Value {
    dvec3 direct{1};
    double sky = 1;
    dvec3 scattered{0};
    double depth_mm = kNoSurface;
  };

  SoftLight(const Scene& scene, const Relief& relief, PictureSize size)
      : scene_(scene),
        lamps_(lamps_of(scene)),
        width_(static_cast<int>(size.width + 1) / 2),
        height_(static_cast<int>(size.height + 1) / 2) {
    for (int row = 0; row < height_; ++row) {
      for (int column = 0; column < width_; ++column) values_.push_back(first_of_four(relief, column, row));
    }
    if (scene.material.scatter_mm <= 0) return;
    scatter(1, 0, relief);
    scatter(0, 1, relief);
  }

  /// Between the places around a pixel.
  Value around(int column, int row, double depth_mm) const {
    Value sum{.direct = dvec3(0), .sky = 0};
    double weights = 0;
    for (const int down : {0, 1}) {
      for (const int right : {0, 1}) {
        const Value& there =
            at(std::min(column / 2 + right, width_ - 1), std::min(row / 2 + down, height_ - 1));
        if (there.depth_mm < 0) continue;
        const double alike = std::max(1 - std::abs(there.depth_mm - depth_mm) / scene_.filter.step_mm, 0.001);
        const double across = right == 1 ? 0.5 * (column % 2) : 1 - 0.5 * (column % 2);
        const double weight = across * (down == 1 ? 0.5 * (row % 2) : 1 - 0.5 * (row % 2)) * alike;
        sum.direct += weight * there.direct;
        sum.sky += weight * there.sky;
        sum.scattered += weight * there.scattered;
        weights += weight;
      }
    }
    if (weights <= 0) return {};
    return {sum.direct / weights, sum.sky / weights, sum.scattered / weights, depth_mm};
  }

 private:
  const Value& at(int column, int row) const {
    return values_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(column)];
  }

  Value first_of_four(const Relief& relief, int column, int row) const {
    for (const int down : {0, 1}) {
      for (const int right : {0, 1}) {
        if (relief.map().surface(2 * column + right, 2 * row + down))
          return of_pixel(relief, 2 * column + right, 2 * row + down);
      }
    }
    return {};
  }

  Value of_pixel(const Relief& relief, int column, int row) const {
    const dvec3 here = relief.point(column, row);
    const dvec3 normal = relief.normal(column, row);
    Value value{.depth_mm = relief.map().depth(column, row)};
    const double known = known_around(scene_, relief, column, row);
    value.sky = known * std::lerp(1.0, sky_seen(scene_, relief, column, row, normal), scene_.light.occlusion);
    int index = 0;
    for (const Scene::Lamp& lamp : lamps_) {
      const dvec3 to_light = to_light_from(scene_, lamp, here);
      const double cosine = glm::dot(normal, to_light);
      const double direct = direct_light(scene_, lamp, relief, column, row, cosine);
      value.direct[index] = known * direct;
      if (scene_.material.scatter_mm > 0) {
        const double through = scene_.material.glow * light_through(scene_, lamp, relief, here, to_light);
        value.scattered[index] = known * std::abs(cosine) * (cosine > 0 ? direct : through);
      }
      ++index;
    }
    return value;
  }

  /// One direction of the Gaussian by the distance between two places of the surface.
  void scatter(int right, int down, const Relief& relief) {
    const double sigma_mm = scene_.material.scatter_mm;
    const int radius = static_cast<int>(std::ceil(std::min(2.3 * sigma_mm / (2 * relief.pixel_mm()), 48.0)));
    std::vector<Value> scattered = values_;
    for (int row = 0; row < height_; ++row) {
      for (int column = 0; column < width_; ++column) {
        const Value& here = at(column, row);
        if (here.depth_mm < 0) continue;
        dvec3 sum(0);
        double weights = 0;
        for (int step = -radius; step <= radius; ++step) {
          const int x = column + step * right;
          const int y = row + step * down;
          if (x < 0 || y < 0 || x >= width_ || y >= height_ || at(x, y).depth_mm < 0) continue;
          const double across_mm = 2 * relief.pixel_mm(here.depth_mm) * step;
          const double below_mm = at(x, y).depth_mm - here.depth_mm;
          const double weight =
              std::exp(-(across_mm * across_mm + below_mm * below_mm) / (2 * sigma_mm * sigma_mm));
          sum += weight * at(x, y).scattered;
          weights += weight;
        }
        scattered[static_cast<std::size_t>(row * width_ + column)].scattered = sum / weights;
      }
    }
    values_ = std::move(scattered);
  }

  const Scene& scene_;
  std::vector<Scene::Lamp> lamps_;
  int width_;
  int height_;
  std::vector<Value> values_;
};

double toned(const Scene::Finish& finish, double light) {
  const double exposed = finish.exposure * light;
  constexpr double kWhite = 3;
  return finish.tone == Tone::kFilm ? exposed * (1 + exposed / (kWhite * kWhite)) / (1 + exposed) : exposed;
}

/// The mean of the rays about a pixel of the viewport that met a surface.
double certainty_about(const std::vector<double>& certainty, PictureSize size, const Scene& scene, int column,
                       int row) {
  const Viewport part = viewport(scene, size);
  const auto within = [](int at, std::uint32_t first, std::uint32_t count) {
    return static_cast<std::size_t>(
        std::clamp(at, static_cast<int>(first), static_cast<int>(first + count) - 1));
  };
  double sum = 0;
  int met = 0;
  for (const int down : {-1, 0, 1}) {
    for (const int right : {-1, 0, 1}) {
      const double there = certainty[within(row + down, part.top, part.height) * size.width +
                                     within(column + right, part.left, part.width)];
      if (there < 0) continue;
      sum += there;
      ++met;
    }
  }
  return met > 0 ? sum / met : 0;
}

/// What is shown of this light, which is at least the haze.
Rgb displayed(const Scene& scene, const dvec3& light) {
  const dvec3 lamp(linear_of(scene.light.red), linear_of(scene.light.green), linear_of(scene.light.blue));
  const dvec3 material(linear_of(scene.material.red), linear_of(scene.material.green),
                       linear_of(scene.material.blue));
  const dvec3 seen = glm::max(light, scene.light.haze * lamp * material);
  const auto shown = [&](double part) { return displayed_of(toned(scene.finish, part)); };
  return {shown(seen.x), shown(seen.y), shown(seen.z)};
}

/// Blinn-Phong, soft light, and the light on the rim; as glass, mixed with that of the layers behind
/// (glass.h). `certainty`: 0 to 1. `layers`: of layers_about().
Rgb lit_colour(const Scene& scene, const Relief& relief, double certainty, const dvec3& layers,
               const SoftLight* soft_light, int column, int row) {
  const Scene::Light& light = scene.light;
  const dvec3 point = relief.point(column, row);
  const dvec3 normal = relief.normal(column, row);
  SoftLight::Value soft;
  if (soft_light != nullptr) soft = soft_light->around(column, row, relief.map().depth(column, row));
  const dvec3 share = scene.material.scatter_mm > 0 ? dvec3(0.9, 0.6, 0.45) : dvec3(0);
  const dvec3 material(linear_of(scene.material.red), linear_of(scene.material.green),
                       linear_of(scene.material.blue));
  const double glass = is_glass(scene) ? 1 - std::pow(1 - scene.glass.amount, 2) : 0;
  dvec3 linear(0);
  dvec3 behind(0);
  int index = 0;
  for (const Scene::Lamp& lamp : lamps_of(scene)) {
    const dvec3 to_light = to_light_from(scene, lamp, point);
    const dvec3 halfway = glm::normalize(to_light + relief.to_viewer(point));
    const double facing = std::max(glm::dot(normal, to_light), 0.0);
    const double highlight =
        facing > 0 ? std::pow(std::max(glm::dot(normal, halfway), 0.0), light.shininess) : 0;
    const double shadowed =
        soft_light != nullptr ? soft.direct[index] : direct_light(scene, lamp, relief, column, row, facing);
    const double direct = std::lerp(shadowed, 1.0, glass);
    const dvec3 matt = glm::mix(dvec3(facing * direct), dvec3(soft.scattered[index]), (1 - glass) * share);
    const dvec3 colour(linear_of(lamp.red), linear_of(lamp.green), linear_of(lamp.blue));
    linear +=
        lamp.strength * colour * (light.diffuse * material * matt + light.specular * highlight * direct);
    const double half_lit = 0.5 * (layers.x + glm::dot(dvec2(layers.y, layers.z), dvec2(to_light)));
    behind += lamp.strength * colour * light.diffuse * material * std::max(half_lit, 0.0);
    ++index;
  }
  const double away = 1 - std::max(glm::dot(normal, relief.to_viewer(point)), 0.0);
  const double rim = light.rim * std::pow(away, 3);

  const dvec3 everywhere(linear_of(light.red), linear_of(light.green), linear_of(light.blue));
  linear += everywhere * material * (light.ambient + rim) * soft.sky;
  linear *= std::lerp(0.3, 1.0, certainty);
  behind += everywhere * material * light.ambient * layers.x;
  if (glass > 0)
    linear = std::lerp(1.0, 1.8, glass) * glm::mix(behind, linear, std::lerp(1.0, std::pow(away, 3), glass));
  const double beyond_mm = std::max(relief.map().depth(column, row) - scene.camera.distance_mm, 0.0);
  const double halves = light.half_mm > 0 ? beyond_mm / light.half_mm : 0;
  const auto kept = [&](double part, double falling) { return part * std::exp2(-halves * falling); };
  return displayed(scene, {kept(linear.x, 1.15), kept(linear.y, 1), kept(linear.z, 0.85)});
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

std::vector<Rgb> twin_light(const std::vector<double>& smooth_mm, const std::vector<double>& certainty,
                            const std::vector<Rgb>& colour, PictureSize size, const Scene& scene) {
  if (!shows_surface(scene.mode)) return colour;
  std::vector<Rgb> shown = scene.mode == Mode::kSlices ? colour : std::vector(smooth_mm.size(), Rgb(0));
  const Relief relief(smooth_mm, size, scene);
  const bool soft = scene.material.scatter_mm > 0 || scene.light.occlusion > 0 || scene.light.fade_mm > 0;
  const auto soft_light = soft ? std::make_unique<SoftLight>(scene, relief, size) : nullptr;
  relief.map().for_each([&](int column, int row) {
    const std::size_t pixel = relief.map().index(column, row);
    if (!relief.map().surface(column, row)) {
      shown[pixel] = scene.mode == Mode::kDepth ? Rgb(0) : displayed(scene, dvec3(0));
    } else if (scene.mode == Mode::kDepth) {
      shown[pixel] = depth_grey(scene.rays, smooth_mm[pixel]);
    } else {
      shown[pixel] =
          lit_colour(scene, relief, certainty_about(certainty, size, scene, column, row),
                     layers_about(colour, size, scene, column, row), soft_light.get(), column, row);
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
