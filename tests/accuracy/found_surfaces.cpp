// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "renderer/survey/auto_scene.hpp"
#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/womb_truth.hpp"

namespace fanlight::test {

namespace {

constexpr PictureSize kFoundSize{256, 256};
constexpr int kPoses = 10;
constexpr double kNearMm = 4;
constexpr int kBeams = 40;  // in a frame, and frames
constexpr double kLongestMm = 250;

/// What a depth map shows at a point in space; a negative depth where that lies beside the picture.
class ShownSurface {
 public:
  ShownSurface(const Scene& scene, const std::vector<float>& depths_mm)
      : frame_(view_frame(scene.camera)), port_(viewport(scene, kFoundSize)), depths_mm_(depths_mm) {
    if (scene.camera.projection == Projection::kParallel) return;
    per_eye_mm_ = 1 / eye_distance_mm(scene.camera);
    at_plane_ = 1 - scene.camera.distance_mm * per_eye_mm_;
  }

  bool shows(const glm::dvec3& point) const {
    const glm::dvec3 from = point - frame_.centre;
    const double depth_mm = glm::dot(from, frame_.forward);
    const double scale = (at_plane_ + depth_mm * per_eye_mm_) * port_.pixel_mm;
    const double column = port_.centre_column() + glm::dot(from, frame_.right) / scale;
    const double row = port_.centre_row() - glm::dot(from, frame_.up) / scale;
    if (!(column > -0.5 && row > -0.5 && column < kFoundSize.width - 0.5 && row < kFoundSize.height - 0.5))
      return false;
    const auto pixel = static_cast<std::size_t>(std::lround(row)) * kFoundSize.width +
                       static_cast<std::size_t>(std::lround(column));
    return depths_mm_[pixel] >= 0 && std::abs(depths_mm_[pixel] - depth_mm) <= kNearMm;
  }

 private:
  ViewFrame frame_;
  Viewport port_;
  const std::vector<float>& depths_mm_;
  double at_plane_ = 1;
  double per_eye_mm_ = 0;
};

/// Of the points at which beams meet the fetus first, those that the picture shows, %.
double shown_percent(const Fetus& fetus, const ScannedFan& fan, const ShownSurface& shown) {
  double all = 0;
  double seen = 0;
  for (int frame = 0; frame < kBeams; ++frame) {
    const double angle_rad =
        fan.first_angle_rad + (fan.last_angle_rad - fan.first_angle_rad) * (frame + 0.5) / kBeams;
    for (int beam = 0; beam < kBeams; ++beam) {
      const double column = (fan.geometry.columns - 1.0) * (beam + 0.5) / kBeams;
      const auto at_row = [&](double row) {
        const PlanePoint at = fan.geometry.plane_point({.column = column, .row = row});
        return to_vector(fan.geometry.point(at.x_mm, {.angle_rad = angle_rad, .depth_mm = at.depth_mm}));
      };
      const PixelRay ray{at_row(0), glm::normalize(at_row(1) - at_row(0))};
      const auto met_mm = fetus.met_mm(ray, 0, kLongestMm);
      if (!met_mm) continue;
      ++all;
      seen += shown.shows(ray.at(*met_mm)) ? 1 : 0;
    }
  }
  return 100 * seen / all;
}

/// Of the surface in the picture, the fetus's, %.
double fetus_percent(const Fetus& fetus, const Scene& scene, const std::vector<float>& depths_mm) {
  const PixelRays rays(scene, kFoundSize);
  double all = 0;
  double of_fetus = 0;
  for (std::uint32_t row = 0; row < kFoundSize.height; ++row) {
    for (std::uint32_t column = 0; column < kFoundSize.width; ++column) {
      const double depth_mm = depths_mm[std::size_t{row} * kFoundSize.width + column];
      if (depth_mm < 0) continue;
      ++all;
      of_fetus += fetus.is_at(rays.ray(column, row).at(depth_mm), kNearMm) ? 1 : 0;
    }
  }
  return 100 * of_fetus / all;
}

FigureRow found_row(const Workbench& bench, const std::string& name, const std::string& options) {
  const ScannedWomb womb = scanned_womb(options);
  const ScannedFan fan = womb.fan();
  Scene scene = scene_for(fan.geometry, fan.first_angle_rad, fan.last_angle_rad, kFoundSize.height);
  bench.change(scene);
  const auto found = auto_scene(womb.volume, scene, kFoundSize);
  double shown = 0;
  double of_fetus = 0;
  if (found) {
    DepthRig rig(bench.gpu, fan, womb.source->description().frames_per_volume, kFoundSize);
    rig.set_volume(womb.volume);
    const std::vector<float> depths_mm = rig.depths(found->scene).smooth_mm;
    const Fetus fetus(*womb.source);
    shown = shown_percent(fetus, fan, ShownSurface(found->scene, depths_mm));
    of_fetus = fetus_percent(fetus, found->scene, depths_mm);
  }
  return {name, {{"shown %", shown, 1, at_least(75)}, {"fetus %", of_fetus, 1, at_least(95)}}};
}

}  // namespace

FigureBlock measure_found_surfaces(const Workbench& bench) {
  FigureBlock block{
      "what \"Find surface\" finds",
      "The fetus before the wall of the uterus, by auto_scene(). shown: of the points at which "
      "40 x 40\nbeams meet the fetus first, those that the picture shows within 4 mm. fetus: of "
      "the surface in the\npicture, the fetus's.",
      {}};
  for (const char* const probe : {"r1", "r2"}) {
    const auto add = [&](const std::string& scene, const std::string& place) {
      const std::string name = fmt::format("found/{}/{}", probe, place);
      if (bench.wants(name)) block.rows.push_back(found_row(bench, name, scene + ",probe=" + probe));
    };
    add("scene=face", "face");
    for (int seed = 1; seed <= kPoses; ++seed) {
      add(fmt::format("scene=womb,seed={}", seed), fmt::format("womb-{}", seed));
      add(fmt::format("scene=womb,wall=off,seed={}", seed), fmt::format("open-{}", seed));
    }
  }
  return block;
}

}  // namespace fanlight::test
