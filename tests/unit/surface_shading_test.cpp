// SPDX-License-Identifier: Apache-2.0
// Passes 2 and 3 on a processor: vectors against lanes of one pixel, in pictures whose memory ends where the
// maps end, so that the address sanitizer sees what is read or written beyond.
#include "renderer/shading/surface_shading.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include "shaders/bindings.h"

namespace fanlight::test::surface_shading_tests {
namespace {

using shading::Method;
using shading::Part;
using shading::Step;

constexpr int kTileSide = 8;
constexpr auto kNoSurface = static_cast<float>(FANLIGHT_NO_SURFACE);

/// A picture with random depths, colours, lights and looks.
struct Case {
  shaders::LightParameters lighting{};
  Method method;
  bool mean = false;
  bool scatters = false;
  int diffusion_steps = 0;
  std::vector<float> depth;
  std::vector<float> confidence;
  std::vector<std::uint32_t> colour;

  explicit Case(std::uint32_t seed) : random_(seed) {
    const int width = whole(1, 70);
    const int height = whole(1, 40);
    lighting.width = static_cast<std::uint32_t>(width);
    lighting.height = static_cast<std::uint32_t>(height);
    lighting.view_left = one_in(2) ? 0 : whole(0, width - 1);
    lighting.view_top = one_in(2) ? 0 : whole(0, height - 1);
    lighting.view_right = one_in(2) ? width - 1 : whole(lighting.view_left - 1, width - 1);
    lighting.view_bottom = one_in(2) ? height - 1 : whole(lighting.view_top - 1, height - 1);
    lighting.centre = {0.5F * static_cast<float>(width), 0.5F * static_cast<float>(height)};
    lighting.pixel = real(0.2F, 0.6F);
    method.perspective = one_in(2);
    lighting.view_scale_at_0 = method.perspective ? 0.5F : 1.0F;
    lighting.view_scale_per_mm = method.perspective ? 0.005F : 0.0F;
    lighting.eye_height = 100;
    lighting.same_surface = real(1, 4);
    lighting.islands_radius = whole(0, 3);
    lighting.holes_radius = whole(0, 3);
    lighting.filter_radius = one_in(10) ? 80 : whole(0, 15);
    lighting.filter_fall = 0.05F;
    lighting.sum_units = 1000;
    lighting.confidence_counts = whole(0, 1);
    lighting.smooth_right = width;
    lighting.smooth_bottom = height;
    mean = one_in(2);
    method.keeps_edges = one_in(2);
    choose_light();
    choose_looks();
    make_maps();
  }

  int whole(int least, int most) { return std::uniform_int_distribution(least, most)(random_); }
  float real(float least, float most) { return std::uniform_real_distribution(least, most)(random_); }
  bool one_in(int number) { return whole(1, number) == 1; }

 private:
  void choose_light() {
    lighting.lamps = whole(0, FANLIGHT_MAX_LAMPS);
    lighting.directional = whole(0, 1);
    for (int lamp = 0; lamp < FANLIGHT_MAX_LAMPS; ++lamp) {
      lighting.lamp_places[lamp] = {real(-40, 40), real(-40, 40), real(-60, 30)};
      const shaders::vec3 direction = {real(-1, 1), real(-1, 1), real(0.1F, 1)};
      const float length = std::hypot(direction.x, direction.y, direction.z);
      lighting.lamp_directions[lamp] = direction / length;
      lighting.lamp_colours[lamp] = {real(0, 1), real(0, 1), real(0, 1)};
      lighting.lamp_distances[lamp] = 100;
    }
    lighting.light_colour = {1, 0.9F, 0.8F};
    lighting.material = {0.9F, 0.7F, 0.6F};
    lighting.ambient = 0.2F;
    lighting.diffuse = 0.7F;
    lighting.specular = one_in(2) ? 0.3F : 0.0F;
    lighting.shininess = 20;
    lighting.central_normals = whole(0, 1);
    lighting.shadow = one_in(3) ? 1.0F : 0.3F;
    lighting.softness = one_in(2) ? 4.0F : 0.0F;
    lighting.shadow_top = -20;
    method.soft_shadows = lighting.softness > 0;
    method.soft_light = one_in(2);
    if (!method.soft_light) return;
    lighting.occlusion = 0.7F;
    lighting.occlusion_reach = 3;
    lighting.fade_reach = one_in(2) ? 2.0F : 0.0F;
    scatters = one_in(2);
    lighting.scattered = {0.5F, 0.3F, 0.2F};
    lighting.scatter_radius = 3;
    lighting.scatter_fall = 0.3F;
    lighting.glow = one_in(2) ? 0.5F : 0.0F;
    lighting.glow_reach = 3;
  }

  void choose_looks() {
    lighting.rim = 0.2F;
    lighting.half_from = 50;
    lighting.halves_per_mm = one_in(2) ? 0.05F : 0.0F;
    lighting.haze = {0.02F, 0.02F, 0.03F};
    lighting.exposure = 1.2F;
    lighting.film = whole(0, 1);
    lighting.glass = one_in(3) ? 0.8F : 0.0F;
    lighting.show = whole(0, 5) > 1 ? FANLIGHT_SHOW_SURFACE
                    : one_in(2)     ? FANLIGHT_SHOW_DEPTH
                                    : FANLIGHT_SHOW_COLOUR;
    lighting.colours_from_left = one_in(4) ? whole(0, static_cast<int>(lighting.width)) : 0;
    lighting.depth_white = 30;
    lighting.depth_scale = 0.02F;
    lighting.outline_radius = whole(0, 2);
    lighting.outline_fall = 0.1F;
    lighting.outline_scale = 1;
    lighting.mean = whole(0, 1);
    lighting.diffusion_scale = 10;
    diffusion_steps = one_in(2) ? whole(1, 3) : 0;
    lighting.map_colours = whole(0, 1);
    for (int point = 0; point < FANLIGHT_MAP_POINTS; ++point) {
      const float grey = static_cast<float>(point) / (FANLIGHT_MAP_POINTS - 1);
      lighting.map_points[point] = {grey, grey * grey, 0.5F * grey};
    }
  }

  void make_maps() {
    for (int y = 0; y < static_cast<int>(lighting.height); ++y) {
      for (int x = 0; x < static_cast<int>(lighting.width); ++x) {
        const bool in_view = x >= lighting.view_left && x <= lighting.view_right && y >= lighting.view_top &&
                             y <= lighting.view_bottom;
        const bool present = in_view && !one_in(12) && (x / 11 + y / 7) % 5 != 0;
        const auto column = static_cast<float>(x);
        depth.push_back(present
                            ? 50 + 4 * std::sin(0.3F * column) + (y > 20 ? 8.0F : 0.0F) + real(-0.2F, 0.2F)
                            : kNoSurface);
        confidence.push_back(present ? real(0, 6) : 0.0F);
        const auto alpha = static_cast<std::uint32_t>(present ? whole(1, 255) : 0);
        colour.push_back(alpha << 24U | static_cast<std::uint32_t>(whole(0, 0xFFFFFF)));
      }
    }
  }

  std::mt19937 random_;
};

struct Results {
  std::vector<float> smooth_depth;
  shaders::MapTotals totals{};
  std::vector<std::uint32_t> finished;
};

/// Of each step, in strips of eight rows as LightHere has them.
void run(Step step, const Case& given, const shading::Memory& memory, const Part& whole) {
  if (step == Step::kTotals) return shading::run(step, given.method, memory, whole);
  if (step == Step::kMeanColumns) {
    for (int left = whole.left; left < whole.right; left += 64)
      shading::run(step, given.method, memory,
                   {left, whole.top, std::min(left + 64, whole.right), whole.bottom});
    return;
  }
  for (int top = whole.top; top < whole.bottom; top += kTileSide)
    shading::run(step, given.method, memory,
                 {whole.left, top, whole.right, std::min(top + kTileSide, whole.bottom)});
}

Results picture_of(const Case& given) {
  const int width = static_cast<int>(given.lighting.width);
  const int height = static_cast<int>(given.lighting.height);
  const auto pixels = static_cast<std::size_t>(width * height);
  const auto tiles =
      static_cast<std::size_t>((width + kTileSide - 1) / kTileSide * ((height + kTileSide - 1) / kTileSide));
  const auto places = static_cast<std::size_t>((width + 1) / 2 * ((height + 1) / 2));
  Results made{.smooth_depth = std::vector<float>(pixels), .finished = std::vector<std::uint32_t>(pixels)};
  std::vector<std::uint32_t> steady(2 * pixels);
  std::vector<float> tile_depths(2 * tiles);
  std::vector<std::uint32_t> cleanup_tiles(tiles);
  std::vector<float> filled(pixels);
  std::vector<std::uint32_t> weights(pixels);
  std::vector<std::uint32_t> lit(2 * pixels);
  // Three maps of soft light fit in a picture from 7 x 7 pixels on.
  std::vector<std::uint32_t> diffused(2 * std::max(pixels, 3 * places));
  shading::Memory memory{.lighting = &given.lighting,
                         .volume_depth = given.depth.data(),
                         .confidence = given.confidence.data(),
                         .volume_colour = given.colour.data(),
                         .steady = steady.data(),
                         .tile_depths = tile_depths.data(),
                         .cleanup_tiles = cleanup_tiles.data(),
                         .filled = filled.data(),
                         .weights = weights.data(),
                         .row_sums = lit.data(),
                         .smooth_depth = made.smooth_depth.data(),
                         .totals = &made.totals,
                         .soft_lights = diffused.data(),
                         .from = lit.data(),
                         .to = lit.data(),
                         .finished = made.finished.data()};
  const Part all = {0, 0, width, height};
  const Part soft = {0, 0, (width + 1) / 2, (height + 1) / 2};
  for (const Step step : {Step::kTake, Step::kTileDepths, Step::kCleanupTiles, Step::kIslands, Step::kHoles,
                          given.mean ? Step::kMeanRows : Step::kSmoothRows,
                          given.mean ? Step::kMeanColumns : Step::kSmoothColumns, Step::kTotals})
    run(step, given, memory, all);
  if (given.method.soft_light) run(Step::kSoftLight, given, memory, soft);
  if (given.scatters) {
    run(Step::kScatterRows, given, memory, soft);
    run(Step::kScatterColumns, given, memory, soft);
  }
  run(Step::kLight, given, memory, all);
  memory.to = diffused.data();
  const auto run_and_swap = [&](Step step) {
    run(step, given, memory, all);
    std::swap(memory.from, memory.to);
  };
  if (given.lighting.outline_radius > 0) run_and_swap(Step::kOutline);
  for (int step = 0; step < given.diffusion_steps; ++step) run_and_swap(Step::kDiffuse);
  run(Step::kFinish, given, memory, all);
  return made;
}

/// The picture by one instruction set.
Results picture_by(std::int64_t target, const Case& given) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().DeInit();  // the next call chooses again
  Results made = picture_of(given);
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
  return made;
}

int difference_of(std::uint32_t a, std::uint32_t b) {
  int most = 0;
  for (const unsigned shift : {0U, 8U, 16U, 24U})
    most =
        std::max(most, std::abs(static_cast<int>(a >> shift & 0xFFU) - static_cast<int>(b >> shift & 0xFFU)));
  return most;
}

class SurfaceShadingTest : public testing::TestWithParam<std::uint32_t> {};

TEST_P(SurfaceShadingTest, IsTheSameInVectorsOfAnyLength) {
  constexpr std::uint32_t kCases = 150;
  std::size_t pixels = 0;
  std::size_t different = 0;
  std::size_t surfaces = 0;
  int compared = 0;
  for (std::uint32_t seed = kCases * GetParam(); seed < kCases * (GetParam() + 1); ++seed) {
    const Case given(seed);
    SCOPED_TRACE(fmt::format("seed {}, {} x {} pixels", seed, given.lighting.width, given.lighting.height));
    const Results by_pixel = picture_by(HWY_SCALAR, given);
    surfaces += by_pixel.totals.surface_pixels;
    for (auto rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
      if ((rest & -rest) == HWY_SCALAR) continue;
      const Results by_vector = picture_by(rest & -rest, given);
      ++compared;
      EXPECT_EQ(by_vector.totals.surface_pixels, by_pixel.totals.surface_pixels);
      EXPECT_EQ(by_vector.totals.uncertain_pixels, by_pixel.totals.uncertain_pixels);
      for (std::size_t pixel = 0; pixel < by_pixel.finished.size(); ++pixel) {
        EXPECT_NEAR(by_vector.smooth_depth[pixel], by_pixel.smooth_depth[pixel], 1e-3F);
        ++pixels;
        different += difference_of(by_vector.finished[pixel], by_pixel.finished[pixel]) > 2 ? 1U : 0U;
      }
    }
  }
  fmt::print("{} pixels, {} of them different; {} surfaces\n", pixels, different, surfaces);
  EXPECT_GE(compared, 1);
  EXPECT_GT(surfaces, 5'000U) << "too little was seen to prove anything";
  EXPECT_LE(different, pixels / 2000);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SurfaceShadingTest, testing::Range(0U, 4U));

}  // namespace
}  // namespace fanlight::test::surface_shading_tests
