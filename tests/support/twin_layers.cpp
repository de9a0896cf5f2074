// SPDX-License-Identifier: Apache-2.0
#include "tests/support/twin_layers.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "tests/support/twin_echo.hpp"
#include "tests/support/twin_edges.hpp"

namespace fanlight::test {

namespace {

using glm::dvec3;

/// In proportion to the growth of the echo to the right, upwards and along the ray: differences along the
/// axes, by two, and along the diagonals of a cube.
dvec3 growth_at(const LayeredRay& layered, double depth_mm, double reach_samples) {
  const dvec3 along = glm::normalize(layered.ray.direction);
  const dvec3 view_right = view_frame(layered.scene.camera).right;
  const dvec3 right = glm::normalize(view_right - glm::dot(view_right, along) * along);
  const dvec3 up = glm::cross(right, along);
  const double reach_mm = reach_samples * step_of(layered.scene, layered.prepared.geometry());
  const dvec3 at = layered.ray.at(depth_mm);
  dvec3 growth(0);
  for (const dvec3& way : {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1), dvec3(1, 1, 1), dvec3(1, 1, -1),
                           dvec3(1, -1, 1), dvec3(1, -1, -1)}) {
    const dvec3 beside = reach_mm * (way.x * right + way.y * up + way.z * along);
    const auto before = twin_echo(layered.scene.speckle, layered.prepared, at - beside);
    const auto after = twin_echo(layered.scene.speckle, layered.prepared, at + beside);
    const bool is_axis = glm::dot(way, way) < 2;
    if (before && after) growth += (is_axis ? 2.0 : 1.0) * (*after - *before) * way;
  }
  return growth;
}

}  // namespace

Rgb twin_layers(const LayeredRay& layered, const std::function<bool(double depth_mm)>& is_shown) {
  Scene::Detector detector = layered.scene.detector;
  detector.sign = EdgeSign::kEither;
  const double threshold = detector.threshold / 255;
  const int half = detector.window / 2;
  const double reach = half >= 4 ? half / 2 : 1;  // whole samples
  const double behind = layered.surface_edge + (detector.place == SurfacePlace::kFirstCrossing ? half : 1);
  dvec3 kept(0);  // opacity, normal
  const auto add = [&](const SteepestWindow& edge, double position) {
    const double depth_mm = layered.scene.rays.start_mm + position * layered.depth_step_mm;
    if (position <= behind || !is_shown(depth_mm) || kept.x >= 0.997) return;
    const dvec3 growth = growth_at(layered, depth_mm, reach);
    const double size = glm::length(growth);
    const double grazing = size > 0 ? 1 - std::abs(growth.z) / size : 0;
    const double strength = std::clamp(edge.height / threshold - 1, 0.0, 1.0);
    const double share = (1 - kept.x) * strength * std::lerp(0.03, 1.0, std::pow(grazing, 3));
    kept += share * dvec3(1, -growth.x / std::max(size, 1e-6), -growth.y / std::max(size, 1e-6));
  };
  auto values = layered.values;
  values.emplace_back();  // nullopt: ends the last run
  std::vector<double> run;
  for (std::size_t index = 0; index < values.size(); ++index) {
    if (values[index]) {
      run.push_back(*values[index]);
      continue;
    }
    const auto heights = window_heights(detector, run);
    const auto first = static_cast<double>(index - run.size());
    for (std::size_t at = 0; at < heights.size(); ++at) {
      if (heights[at] <= threshold || (at > 0 && heights[at - 1] > threshold)) continue;
      const SteepestWindow edge = steepest_window(heights, at, threshold);
      add(edge, first + edge.position + 0.5 * (detector.window - 1));
    }
    run.clear();
  }
  return {kept.x, 0.5 + 0.5 * kept.y, 0.5 + 0.5 * kept.z};
}

}  // namespace fanlight::test
