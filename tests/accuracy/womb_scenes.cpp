// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/womb_truth.hpp"
#include "tests/support/pixel_rays.hpp"

namespace fanlight::test {

namespace {

constexpr PictureSize kWombSize{192, 192};
constexpr int kWombs = 20;
// Of the truth: what is further off shows something else.
constexpr double kNearMm = 3;
constexpr double kSameMm = 1;
constexpr double kWallMm = 1;

/// What a scene shows of the womb.
struct WombView {
  std::vector<bool> fetus;        ///< of each pixel, whether it shows the fetus, within kNearMm of the truth
  std::vector<double> errors_mm;  ///< of these, sorted
  double wall = 0;                ///< pixels that show the near wall
  std::vector<float> shown_mm;
};

WombView viewed(const Fetus& fetus, const Scene& scene, std::vector<float> shown_mm) {
  const PixelRays rays(scene, kWombSize);
  WombView view{
      .fetus = std::vector<bool>(shown_mm.size()), .errors_mm = {}, .shown_mm = std::move(shown_mm)};
  for (std::uint32_t row = 0; row < kWombSize.height; ++row) {
    for (std::uint32_t column = 0; column < kWombSize.width; ++column) {
      const std::size_t pixel = std::size_t{row} * kWombSize.width + column;
      const double depth_mm = view.shown_mm[pixel];
      if (depth_mm < 0) continue;
      const PixelRay ray = rays.ray(column, row);
      const BodyScene::Found found = fetus.at(ray.at(depth_mm));
      view.wall += found.part == BodyScene::Part::kNearWall && found.distance_mm < kWallMm ? 1 : 0;
      const auto truth_mm = fetus.met_mm(ray, rays.first_mm(), rays.last_mm());
      if (!truth_mm || std::abs(depth_mm - *truth_mm) > kNearMm) continue;
      view.fetus[pixel] = true;
      view.errors_mm.push_back(depth_mm - *truth_mm);
    }
  }
  std::ranges::sort(view.errors_mm);
  return view;
}

/// Of the pixels that show the fetus where there is no wall, those that show it at the same place, %.
double kept_percent(const WombView& without_wall, const WombView& view) {
  double all = 0;
  double kept = 0;
  for (std::size_t pixel = 0; pixel < without_wall.fetus.size(); ++pixel) {
    if (!without_wall.fetus[pixel]) continue;
    ++all;
    const double apart_mm = std::abs(view.shown_mm[pixel] - without_wall.shown_mm[pixel]);
    kept += view.shown_mm[pixel] >= 0 && apart_mm <= kSameMm ? 1 : 0;
  }
  return 100 * kept / all;
}

FigureRow womb_row(const Workbench& bench, const std::string& name, int seed) {
  const ScannedWomb walled = scanned_womb(fmt::format("scene=womb,seed={}", seed));
  const ScannedWomb open = scanned_womb(fmt::format("scene=womb,wall=off,seed={}", seed));
  const ScannedFan fan = walled.fan();
  DepthRig rig(bench.gpu, fan, walled.source->description().frames_per_volume, kWombSize);
  Scene scene = scene_for(fan.geometry, fan.first_angle_rad, fan.last_angle_rad, kWombSize.height);
  bench.change(scene);
  const auto view_of = [&](const ScannedWomb& womb, NearTissueShow tissue) {
    scene.near.tissue = tissue;
    rig.set_volume(womb.volume);
    return viewed(Fetus(*womb.source), scene, rig.depths(scene).smooth_mm);
  };
  const WombView without_wall = view_of(open, NearTissueShow::kShown);
  const WombView before = view_of(walled, NearTissueShow::kShown);
  const WombView removed = view_of(walled, NearTissueShow::kRemoved);

  const double pixels = kWombSize.width * kWombSize.height;
  const auto median_mm = [](const std::vector<double>& errors) {
    return errors.empty() ? std::nan("") : errors[errors.size() / 2];
  };
  return {name,
          {{"gap mm", walled.source->bodies()->gap_mm(), 1},
           {"before: kept %", kept_percent(without_wall, before), 1},
           {"wall %", 100 * before.wall / pixels, 1},
           {"removed: kept %", kept_percent(without_wall, removed), 1, at_least(95)},
           {"wall %", 100 * removed.wall / pixels, 2, at_most(2)},
           {"median mm", median_mm(removed.errors_mm), 2},
           {"without wall: median mm", median_mm(without_wall.errors_mm), 2}}};
}

}  // namespace

FigureBlock measure_wombs(const Workbench& bench) {
  FigureBlock block{
      "a fetus behind near tissue",
      "phantom:scene=womb, seen by the default scene, as it is (before) and with near.tissue removed. gap:\n"
      "least fluid between the near wall and the fetus. kept: of the pixels that show the fetus, within 3 "
      "mm\n"
      "of the truth, in the same scene with wall=off, those that show a surface within 1 mm of that one. "
      "wall:\n"
      "pixels of the picture that show the near wall. median: signed error of the fetus's pixels.",
      {}};
  for (int seed = 1; seed <= kWombs; ++seed) {
    const std::string name = fmt::format("womb/r2/{}", seed);
    if (bench.wants(name)) block.rows.push_back(womb_row(bench, name, seed));
  }
  return block;
}

}  // namespace fanlight::test
