// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/light_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <optional>

#include "renderer/parameters/cast_parameters.hpp"
#include "shaders/bindings.h"
#include "shaders/steady_parameters.h"

namespace fanlight {

namespace {

/// Linear components of a displayed colour (sRGB).
glm::vec3 linear(double red, double green, double blue) {
  const auto decoded = [](double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  return {decoded(red), decoded(green), decoded(blue)};
}

void set_viewport(shaders::LightParameters& to, const Scene& scene, PictureSize size) {
  const Viewport port = viewport(scene, size);
  to.width = size.width;
  to.height = size.height;
  to.view_left = static_cast<int>(port.left);
  to.view_top = static_cast<int>(port.top);
  to.view_right = static_cast<int>(port.left + port.width) - 1;
  to.view_bottom = static_cast<int>(port.top + port.height) - 1;
  to.centre = {port.centre_column(), port.centre_row()};
  to.pixel = static_cast<float>(port.pixel_mm);
  const double eye_mm = eye_distance_mm(scene.camera);
  const double height_mm = eye_height_mm(scene.camera);
  const bool from_eye = is_perspective(scene.camera);
  to.view_scale_at_0 = static_cast<float>(from_eye ? height_mm / eye_mm : 1);
  to.view_scale_per_mm = static_cast<float>(from_eye ? 1 / eye_mm : 0);
  to.eye_height = static_cast<float>(height_mm);
  // At least 1 mm in front of the eye, where the eye lies beyond the view plane: nothing visible is nearer.
  to.shadow_top =
      static_cast<float>(from_eye ? -std::max(scene.rays.start_mm, 1 - height_mm) : -scene.rays.start_mm);
}

void set_filter(shaders::LightParameters& to, const Scene& scene, double farthest_mm) {
  const Scene::Filter& filter = scene.filter;
  to.same_surface = static_cast<float>(filter.step_mm);
  to.islands_radius = filter.islands / 2;
  to.holes_radius = filter.holes / 2;
  to.filter_radius = filter.size / 2;
  const double sigma_pixels = filter.size / 5.0;
  to.filter_fall = static_cast<float>(1 / (2 * sigma_pixels * sigma_pixels));
  to.confidence_counts = filter.weights == FilterWeights::kConfidence ? 1 : 0;
  // The largest sum: a window of the deepest surface everywhere, with the largest weight.
  const int most_weight = to.confidence_counts != 0 ? FANLIGHT_MAX_WEIGHT : 1;
  const double largest_mm =
      std::max(farthest_mm - scene.rays.start_mm, 1.0) * filter.size * filter.size * most_weight;
  constexpr double kFinestUnits = 16384;
  to.sum_units = static_cast<float>(std::min(4.0e9 / largest_mm, kFinestUnits));
}

/// The lights that are on, first the key light.
void set_lamps(shaders::LightParameters& to, const Scene& scene) {
  const auto add = [&](const auto& lamp) {
    if (lamp.on == LightSwitch::kOff || lamp.strength <= 0) return;
    const int index = to.lamps++;
    to.lamp_places[index] = {lamp.right_mm, lamp.up_mm, -lamp.depth_mm};
    const glm::dvec3 from_target(lamp.right_mm, lamp.up_mm, scene.camera.distance_mm - lamp.depth_mm);
    const double distance_mm = glm::length(from_target);
    to.lamp_directions[index] = distance_mm > 0 ? from_target / distance_mm : glm::dvec3(0, 0, 1);
    to.lamp_distances[index] = static_cast<float>(std::max(distance_mm, 1e-3));
    to.lamp_colours[index] = static_cast<float>(lamp.strength) * linear(lamp.red, lamp.green, lamp.blue);
  };
  add(scene.light);
  add(scene.fill_light);
  add(scene.back_light);
}

void set_light(shaders::LightParameters& to, const Scene& scene) {
  const Scene::Light& light = scene.light;
  set_lamps(to, scene);
  to.directional = light.kind == LightKind::kDirectional ? 1 : 0;
  to.light_colour = linear(light.red, light.green, light.blue);
  to.material = linear(scene.material.red, scene.material.green, scene.material.blue);
  to.ambient = static_cast<float>(light.ambient);
  to.diffuse = static_cast<float>(light.diffuse);
  to.specular = static_cast<float>(light.specular);
  to.shininess = static_cast<float>(light.shininess);
  to.central_normals = light.normals == Normals::kCentral ? 1 : 0;
  to.half_from = static_cast<float>(scene.camera.distance_mm);
  to.halves_per_mm = light.half_mm > 0 ? static_cast<float>(1 / light.half_mm) : 0;
  to.haze = static_cast<float>(light.haze) * to.light_colour * to.material;
  to.shadow = static_cast<float>(scene.shadow.coefficient);
  to.softness = static_cast<float>(scene.shadow.softness_mm);
}

bool has_soft_light(const Scene& scene) {
  return shown_by(scene.mode) == FANLIGHT_SHOW_SURFACE &&
         (scene.material.scatter_mm > 0 || scene.light.occlusion > 0 || scene.light.fade_mm > 0);
}

/// The share of each colour that skin scatters: red light goes deepest. Chosen by eye, in the order of the
/// mean free paths of skin (Jensen et al., "A practical model for subsurface light transport", 2001, table
/// 1).
constexpr glm::vec3 kScatteredShare(0.9F, 0.6F, 0.45F);
/// Thickness through which 1 / e of the light comes, over the distance at which it spreads.
constexpr double kGlowReach = 2;
/// The window of the scattering, in standard deviations.
constexpr double kScatterReach = 2.3;

void set_soft_light(shaders::LightParameters& to, const Scene& scene) {
  const double scatter_mm = scene.material.scatter_mm;
  to.rim = static_cast<float>(scene.light.rim);
  // In equal steps to the eye: most of the light that comes through is seen at once.
  const double skin = is_glass(scene) ? 1 - scene.glass.amount : 1;
  to.glass = static_cast<float>(1 - skin * skin);
  to.exposure = static_cast<float>(scene.finish.exposure);
  to.film = scene.finish.tone == Tone::kFilm ? 1 : 0;
  if (!has_soft_light(scene)) return;
  to.occlusion = static_cast<float>(scene.light.occlusion);
  to.occlusion_reach = static_cast<float>(scene.light.occlusion_mm);
  to.fade_reach = static_cast<float>(scene.light.fade_mm);
  if (scatter_mm <= 0) return;
  constexpr double kMostPlaces = 48;
  const double places = kScatterReach * scatter_mm / (2.0 * to.pixel);
  to.scattered = kScatteredShare;
  to.scatter_radius = static_cast<int>(std::ceil(std::min(places, kMostPlaces)));
  to.scatter_fall = static_cast<float>(1 / (2 * scatter_mm * scatter_mm));
  to.glow = static_cast<float>(scene.material.glow);
  to.glow_reach = static_cast<float>(kGlowReach * scatter_mm);
}

/// The scale is that of an outline between two columns: with it, the pixels next to it are half a pixel away,
/// and an outline along the pixels stays as it is.
void set_outline(shaders::LightParameters& to, int radius) {
  const double fall = 1.0 / ((radius + 1) * (radius + 1));
  double middle = 0;   // weights of the middle column
  double offsets = 0;  // weighted offsets of the columns to its right
  for (int row = -radius; row <= radius; ++row) {
    for (int column = 0; column <= radius; ++column) {
      const double weight = std::max(1 - fall * (row * row + column * column), 0.0);
      (column == 0 ? middle : offsets) += column == 0 ? weight : weight * column;
    }
  }
  to.outline_radius = radius;
  to.outline_fall = static_cast<float>(fall);
  to.outline_scale = static_cast<float>(offsets / middle);
}

PipelineKey smooth_key(bool along_columns, bool keeps_edges) {
  return {.shader = Shader::kSmooth, .constants = {along_columns ? 1 : 0, keeps_edges ? 1 : 0}};
}

PipelineKey light_key(bool perspective, bool soft_shadows, bool soft_light) {
  // Soft light comes with its shadows.
  const bool casts_soft_shadows = soft_shadows && !soft_light;
  return {.shader = Shader::kLight,
          .constants = {perspective ? 1 : 0, casts_soft_shadows ? 1 : 0, soft_light ? 1 : 0}};
}

PipelineKey soft_light_key(bool perspective, bool soft_shadows) {
  return {.shader = Shader::kSoftLight, .constants = {perspective ? 1 : 0, soft_shadows ? 1 : 0}};
}

PipelineKey scatter_key(bool along_columns, bool perspective) {
  return {.shader = Shader::kScatter, .constants = {along_columns ? 1 : 0, perspective ? 1 : 0}};
}

}  // namespace

PipelineKey map_cells_key(bool earlier) {
  return {.shader = Shader::kMapCells, .constants = {earlier ? 1 : 0}};
}

PipelineKey temporal_key(int kind) {
  return {.shader = Shader::kTemporal, .constants = {kind}};
}

shaders::LightParameters light_parameters(const Scene& scene, PictureSize size, double farthest_mm) {
  shaders::LightParameters to{};
  set_viewport(to, scene, size);
  set_filter(to, scene, farthest_mm);
  set_light(to, scene);
  set_soft_light(to, scene);
  to.show = shown_by(scene.mode);
  to.colours_from_left = scene.mode == Mode::kSurfaceAndVolume ? static_cast<int>(size.width / 2) : 0;
  to.depth_white = static_cast<float>(scene.rays.start_mm);
  to.depth_scale = static_cast<float>(1 / (scene.rays.end_mm - scene.rays.start_mm));
  if (to.show != FANLIGHT_SHOW_COLOUR && scene.finish.outline > 0) set_outline(to, scene.finish.outline);
  to.mean = scene.finish.smoothing == Smoothing::kMean ? 1 : 0;
  to.diffusion_scale = static_cast<float>(kGreyLevels / scene.finish.conductance);
  to.map_colours = scene.finish.colours == ColourMap::kNone ? 0 : 1;
  const auto points = colour_map_points(scene.finish.colours);
  std::ranges::copy(points, std::begin(to.map_points));
  return to;
}

LightKeys light_keys(const Scene& scene) {
  const bool mean = scene.filter.kind == DepthFilter::kMean;
  const bool keeps_edges = scene.filter.kind == DepthFilter::kEdgePreserving;
  const bool perspective = is_perspective(scene.camera);
  const bool soft_shadows = scene.shadow.softness_mm > 0;
  const bool soft_light = has_soft_light(scene);
  const bool scatters = soft_light && scene.material.scatter_mm > 0;
  const std::optional<PipelineKey> none;
  return {
      .filter_rows = mean ? PipelineKey{.shader = Shader::kMeanRows} : smooth_key(false, keeps_edges),
      .filter_columns = mean ? PipelineKey{.shader = Shader::kMeanColumns} : smooth_key(true, keeps_edges),
      .soft_light = soft_light ? soft_light_key(perspective, soft_shadows) : none,
      .scatter_rows = scatters ? scatter_key(false, perspective) : none,
      .scatter_columns = scatters ? scatter_key(true, perspective) : none,
      .light = light_key(perspective, soft_shadows, soft_light)};
}

std::array<PipelineKey, kTemporalVariants> temporal_variants() {
  return {map_cells_key(false), map_cells_key(true), temporal_key(FANLIGHT_TEMPORAL_ALONE),
          temporal_key(FANLIGHT_TEMPORAL_STEADY), temporal_key(FANLIGHT_TEMPORAL_SEAM)};
}

std::array<PipelineKey, kLightVariants> light_variants() {
  std::array<PipelineKey, kLightVariants> variants;
  auto* next = variants.data();
  for (const bool first : {false, true}) {
    for (const bool second : {false, true}) {
      *next++ = light_key(first, second, false);
      if (second) *next++ = light_key(first, second, true);
      *next++ = soft_light_key(first, second);
      *next++ = scatter_key(first, second);
      *next++ = smooth_key(first, second);
    }
  }
  return variants;
}

std::array<glm::dvec3, FANLIGHT_MAP_POINTS> colour_map_points(ColourMap map) {
  const glm::dvec3 black(0, 0, 0);
  switch (map) {
    case ColourMap::kSepia:
      return {black, {0.29, 0.20, 0.13}, {0.69, 0.56, 0.40}, {1.00, 0.95, 0.84}};
    case ColourMap::kGold:
      return {black, {0.45, 0.20, 0.02}, {0.85, 0.55, 0.12}, {1.00, 0.95, 0.70}};
    case ColourMap::kIce:
      return {black, {0.05, 0.22, 0.45}, {0.35, 0.62, 0.85}, {0.92, 0.98, 1.00}};
    case ColourMap::kHeat:
      return {black, {0.55, 0.00, 0.00}, {1.00, 0.55, 0.00}, {1.00, 1.00, 0.85}};
    case ColourMap::kNone:
    case ColourMap::kGrey:
      break;
  }
  return {black, glm::dvec3(1.0 / 3), glm::dvec3(2.0 / 3), glm::dvec3(1)};
}

}  // namespace fanlight
