// Each pass on the GPU against its CPU twin, over seeded volumes, views and options.
#include <fmt/format.h>

#include <cmath>
#include <random>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test {
namespace {

constexpr PictureSize kSize{.width = 61, .height = 53};  // no multiple of a work group

struct Case {
  FanGeometry geometry;
  std::vector<double> angles_rad;
  Scene scene;
  std::function<double(const Point&)> grey;
};

/// A small fan with frames at uneven angles in either order, smooth bodies in fluid, and a view of them.
Case seeded_case(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };

  Case made;
  made.geometry = {.columns = 72,
                   .rows = 88,
                   .pixel_width_mm = between(0.4, 0.9),
                   .pixel_height_mm = between(0.4, 0.9),
                   .face_column = between(28, 44),
                   .face_row = between(-2, 5),
                   .motor_radius_mm = between(10, 40)};
  if (seed % 3 == 0)
    made.geometry.sector = {.probe_radius_mm = between(15, 40), .half_angle_deg = between(25, 40)};
  double angle_rad = radians(between(-40, -25));
  for (int frame = 0; frame < 24; ++frame) {
    made.angles_rad.push_back(angle_rad);
    angle_rad += radians(between(1.0, 4.0));
  }
  if (seed % 2 == 1) std::ranges::reverse(made.angles_rad);

  const double depth_mm = made.geometry.depth_mm();
  const double body_mm = between(0.5, 0.8) * depth_mm;
  const double ripple_mm = between(5, 12);
  made.grey = [=](const Point& at) {
    const double surface_mm = body_mm + 3 * std::sin(at.x_mm / ripple_mm) + 3 * std::cos(at.z_mm / ripple_mm);
    return 12 + 130 / (1 + std::exp(-(at.y_mm - surface_mm)));
  };

  Scene& scene = made.scene;
  scene = scene_for(made.geometry, *std::ranges::min_element(made.angles_rad),
                    *std::ranges::max_element(made.angles_rad));
  scene.camera.yaw_deg += between(-25, 25);
  scene.camera.pitch_deg += between(-25, 25);
  scene.camera.roll_deg = between(-180, 180);
  scene.camera.field_mm *= between(0.5, 0.9);
  scene.rays.start_mm = between(0, 5);
  scene.rays.step_mm = seed % 4 == 0 ? between(0.3, 0.8) : 0;
  scene.detector.window = 2 * std::uniform_int_distribution(1, 16)(random);
  // A short window sees but a part of the step.
  scene.detector.threshold = between(10, 30) * std::min(1.0, scene.detector.window / 8.0);
  scene.detector.sign = static_cast<EdgeSign>(seed % 3 == 1 ? 2 : 0);
  scene.filter.size = 2 * std::uniform_int_distribution(0, 15)(random) + 1;
  scene.light = {.right_mm = between(-60, 60),
                 .up_mm = between(-60, 60),
                 .depth_mm = between(-50, 10),
                 .ambient = between(0, 0.3),
                 .diffuse = between(0.4, 1),
                 .specular = between(0, 0.6),
                 .shininess = between(1, 60)};
  scene.shadow.coefficient = seed % 4 == 3 ? 1 : between(0, 0.9);
  scene.mode = seed % 5 == 4 ? Mode::kVolume : Mode::kSurface;
  scene.finish = Finish::kNone;
  return made;
}

struct Rendered {
  Picture raw;       // pass 3 off
  Picture finished;  // pass 3 on
  DepthMaps depths;
};

std::vector<double> as_double(const std::vector<float>& values) {
  return {values.begin(), values.end()};
}

/// Share of the picture's values that lie within `levels` of 255 of the twin's.
double share_within(const Picture& picture, const std::vector<Rgb>& twin, double levels) {
  std::size_t within = 0;
  for (std::size_t pixel = 0; pixel < twin.size(); ++pixel) {
    bool all = true;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      all &= std::abs(picture.rgba[4 * pixel + channel] - 255 * twin[pixel][channel]) <= levels;
    }
    within += all ? 1 : 0;
  }
  return static_cast<double>(within) / static_cast<double>(twin.size());
}

std::vector<Rgb> as_rgb(const Picture& picture) {
  std::vector<Rgb> values;
  for (std::size_t at = 0; at < picture.rgba.size(); at += 4) {
    values.push_back({picture.rgba[at] / 255.0, picture.rgba[at + 1] / 255.0, picture.rgba[at + 2] / 255.0});
  }
  return values;
}

class TwinTest : public GpuTest, public testing::WithParamInterface<std::uint32_t> {
 protected:
  static Rendered render(const Case& given, const Volume& volume) {
    RenderCounters counters;
    const auto renderer = made_renderer(given.geometry, given.angles_rad, kSize, given.scene, counters);
    if (auto loaded = renderer->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    Rendered rendered;
    rendered.raw = next_picture(*renderer);
    rendered.depths = *renderer->read_depth();
    Scene mean = given.scene;
    mean.finish = Finish::kMean;
    renderer->show({.revision = 2, .scene = mean});
    rendered.finished = next_picture(*renderer);
    return rendered;
  }
};

TEST_P(TwinTest, EachPassIsWhatTheTwinSays) {
  const Case given = seeded_case(GetParam());
  const Volume volume = made_volume(given.geometry, given.angles_rad, given.grey);
  const Rendered gpu = render(given, volume);

  const TwinCast cast = twin_cast(given.scene, kSize, volume);
  std::size_t same_outcome = 0;
  std::size_t hits = 0;
  std::size_t near = 0;
  for (std::size_t pixel = 0; pixel < cast.depth_mm.size(); ++pixel) {
    const bool twin_hit = cast.depth_mm[pixel] >= 0;
    const bool gpu_hit = gpu.depths.cast_mm[pixel] >= 0;
    same_outcome += twin_hit == gpu_hit ? 1 : 0;
    if (!twin_hit || !gpu_hit) continue;
    ++hits;
    near += std::abs(cast.depth_mm[pixel] - gpu.depths.cast_mm[pixel]) <= 0.05 ? 1 : 0;
  }
  const double pixels = static_cast<double>(cast.depth_mm.size());
  const double outcome_share = static_cast<double>(same_outcome) / pixels;
  const double near_share = static_cast<double>(near) / static_cast<double>(hits);
  fmt::print("seed {}: hits {:.3f}, same outcome {:.4f}, depth within 0.05 mm {:.4f}\n", GetParam(),
             static_cast<double>(hits) / pixels, outcome_share, near_share);
  EXPECT_GT(hits, pixels / 20) << "the case shows too little to prove anything";
  EXPECT_GE(outcome_share, 0.998);
  EXPECT_GE(near_share, 0.99);

  const auto smooth = twin_filter(as_double(gpu.depths.cast_mm), kSize, given.scene.filter.size);
  for (std::size_t pixel = 0; pixel < smooth.size(); ++pixel) {
    ASSERT_NEAR(gpu.depths.smooth_mm[pixel], smooth[pixel], 1e-3) << "pixel " << pixel;
  }

  const auto lit = given.scene.mode == Mode::kVolume
                       ? cast.colour
                       : twin_light(as_double(gpu.depths.smooth_mm), kSize, given.scene);
  EXPECT_GE(share_within(gpu.raw, lit, 2), 0.999);
  EXPECT_EQ(share_within(gpu.finished, twin_finish(as_rgb(gpu.raw), kSize, Finish::kMean), 1), 1.0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TwinTest, testing::Range(0U, 20U));

}  // namespace
}  // namespace fanlight::test
