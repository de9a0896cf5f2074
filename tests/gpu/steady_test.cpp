// SPDX-License-Identifier: Apache-2.0
// The temporal filter of pass 2, over sequences of volumes.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"
#include "tests/support/twin_steady.hpp"

namespace fanlight::test::steady_tests {
namespace {

constexpr const FanGeometry& kGeometry = kMapFan;
constexpr PictureSize kPicture{.width = 150, .height = 110};
constexpr double kShare = 0.8;  // five volumes

std::vector<double> sweep_rad() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 41; ++frame) angles_rad.push_back(radians(1.3 * (frame - 20)));
  return angles_rad;
}

/// What moves between two volumes, mm.
struct Step {
  double body_right = 0;  // the whole body
  double body_deeper = 0;
  double ball_right = 0;  // a ball before it, besides
};

/// Waves in fluid and a ball before them, with noise.
Volume volume_of(const Step& moved, std::uint32_t number, double noise = 12) {
  const auto grey = [=, bits = std::mt19937(number)](const Point& at) mutable {
    const double x = at.x_mm - moved.body_right;
    const double wave =
        40 + 3 * std::sin(x / 4) + 3 * std::cos(at.z_mm / 5) + 2 * std::sin((x + at.z_mm) / 7);
    const double below = at.y_mm - moved.body_deeper - wave;
    const double ball =
        7 - glm::length(glm::dvec3(x - moved.ball_right + 12, at.y_mm - moved.body_deeper - 30, at.z_mm - 4));
    const double inside = std::max(below, ball);
    const double random = noise * (static_cast<double>(bits()) / 0x1p31 - 1);
    return 90 + 80 * std::clamp(inside / 1.5, -1.0, 1.0) + random;
  };
  Volume volume = made_volume(kGeometry, sweep_rad(), grey);
  volume.stamp().volume_id = number;
  return volume;
}

/// The depth map is that of the temporal filter.
Scene scene_of_test() {
  const auto angles_rad = sweep_rad();
  Scene scene = scene_for(kGeometry, angles_rad.front(), angles_rad.back());
  scene.camera.target = {.x_mm = 0, .y_mm = 40, .z_mm = 0};
  scene.camera.field_mm = 60;
  scene.detector = {.threshold = 30};
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.filter = {.size = 1, .step_mm = 3, .islands = 1, .holes = 1, .steady = kShare};
  return scene;
}

struct Setting {
  const char* name;
  Projection projection;
  bool own_light_device;
};
void PrintTo(const Setting& setting, std::ostream* out) {
  *out << setting.name;
}

class SteadySequenceTest : public GpuTest, public testing::WithParamInterface<Setting> {};

TEST_P(SteadySequenceTest, IsWhatTheTwinSays) {
  Scene scene = scene_of_test();
  scene.camera.projection = GetParam().projection;
  RenderCounters counters;
  const auto renderer = made_renderer(kGeometry, sweep_rad(), kPicture, scene, counters,
                                      {.rays_by_shader = GetParam().own_light_device,
                                       .own_light_device = GetParam().own_light_device,
                                       .largest_size = PictureSize{.width = 200, .height = 160}});
  constexpr std::array<Step, 6> kSteps = {{{},
                                           {.body_right = 0.6, .body_deeper = 0.4},
                                           {.body_right = 0.2, .body_deeper = 1.0, .ball_right = 1.5},
                                           {.body_right = 0.2, .body_deeper = 1.0, .ball_right = 1.5},
                                           {.body_right = -0.3, .body_deeper = 0.8, .ball_right = 1.5},
                                           {.body_right = -0.1, .body_deeper = 0.9, .ball_right = 1.5}}};
  std::optional<TwinSteadyMap> twin;
  PictureSize size = kPicture;
  for (std::uint32_t number = 1; number <= kSteps.size(); ++number) {
    if (number == 5) {  // another view: turned, and finer
      scene.camera.yaw_deg += 7;
      scene.camera.pitch_deg -= 4;
      scene.size = size = {.width = 200, .height = 160};
    }
    renderer->show({.revision = number, .scene = scene});
    ASSERT_TRUE(renderer->load(volume_of(kSteps[number - 1], number)));
    // With a new revision the volume before may be lit once more.
    Picture picture = next_picture(*renderer);
    while (picture.stamp.volume.volume_id != number) picture = next_picture(*renderer);
    const DepthMaps maps = *renderer->read_depth();
    TwinSteadyMap now = twin_single(scene, size, {maps.cast_mm.begin(), maps.cast_mm.end()});
    twin = twin ? twin_steady(now, *twin) : now;

    double agree = 0;
    double surfaces = 0;
    double volumes = 0;
    double steady = 0;
    for (std::size_t pixel = 0; pixel < maps.cast_mm.size(); ++pixel) {
      ASSERT_EQ(maps.smooth_mm[pixel] < 0, twin->depth_mm[pixel] < 0);
      if (maps.smooth_mm[pixel] < 0) continue;
      ++surfaces;
      const bool is_steady = twin->volumes[pixel] >= 1.3;
      steady += is_steady ? 1 : 0;
      volumes += is_steady ? twin->volumes[pixel] : 0;
      agree += std::abs(maps.smooth_mm[pixel] - twin->depth_mm[pixel]) <= 0.01 ? 1 : 0;
    }
    ASSERT_GT(surfaces, maps.cast_mm.size() / 3);
    // Rounding may decide whether a cell at a border counts.
    EXPECT_GE(agree / surfaces, 0.98) << "volume " << number;
    EXPECT_NEAR(picture.stamp.steady_share, steady / surfaces, 0.02) << "volume " << number;
    EXPECT_NEAR(picture.stamp.mean_volumes, steady > 0 ? volumes / steady : 1, 0.04) << "volume " << number;
    constexpr std::array<double, 6> kLeastVolumes = {1, 1.6, 2, 2.5, 2.5, 3};
    EXPECT_GE(picture.stamp.mean_volumes, kLeastVolumes[number - 1]) << "the whole body moves alike";
  }
}

INSTANTIATE_TEST_SUITE_P(Views, SteadySequenceTest,
                         testing::Values(Setting{"parallel", Projection::kParallel, false},
                                         Setting{"perspective", Projection::kPerspective, false},
                                         Setting{"two devices", Projection::kPerspective, true}));

class SteadyTest : public GpuTest {
 protected:
  Scene scene_ = scene_of_test();
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = made_renderer(kGeometry, sweep_rad(), kPicture, scene_, counters_);
  std::uint32_t number_ = 0;

  Picture shown(const Step& moved, Renderer::Loading loading = Renderer::Loading::kNew) {
    if (auto loaded = renderer_->load(volume_of(moved, ++number_), loading); !loaded)
      throw std::runtime_error(loaded.error().message);
    return next_picture(*renderer_);
  }
  Picture changed() {
    renderer_->show({.revision = ++revision_, .scene = scene_});
    return next_picture(*renderer_);
  }

 private:
  std::uint64_t revision_ = 1;
};

TEST_F(SteadyTest, AveragesUpToAsManyVolumesAsTheShareSays) {
  EXPECT_EQ(shown({}).stamp.mean_volumes, 1);
  for (int more = 0; more < 6; ++more) shown({});
  const double mean = shown({}).stamp.mean_volumes;
  EXPECT_GT(mean, 4.3);
  EXPECT_LE(mean, 5);
}

TEST_F(SteadyTest, MakesNoiseLess) {
  const auto maps_of = [&](double noise) {
    if (auto loaded = renderer_->load(volume_of({}, ++number_, noise)); !loaded)
      throw std::runtime_error(loaded.error().message);
    next_picture(*renderer_);
    return *renderer_->read_depth();
  };
  const DepthMaps first = maps_of(12);
  for (int more = 0; more < 4; ++more) maps_of(12);
  const DepthMaps last = maps_of(12);
  const DepthMaps truth = maps_of(0);
  const auto error_mm = [&](const std::vector<float>& depth_mm) {
    std::vector<double> errors;
    for (std::size_t pixel = 0; pixel < depth_mm.size(); ++pixel) {
      if (depth_mm[pixel] >= 0 && truth.cast_mm[pixel] >= 0)
        errors.push_back(std::abs(depth_mm[pixel] - truth.cast_mm[pixel]));
    }
    std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2));
    return errors[errors.size() / 2];
  };
  EXPECT_LT(error_mm(last.smooth_mm), 0.6 * error_mm(first.smooth_mm)) << "five volumes; independent: 0.33";
}

TEST_F(SteadyTest, DropsWhatMovesByItselfAndKeepsTheRest) {
  for (int number = 0; number < 5; ++number) shown({});
  const DepthMaps before = *renderer_->read_depth();
  shown({.ball_right = 2.5});
  const DepthMaps moved = *renderer_->read_depth();
  // The same volume alone.
  scene_.filter.steady = 0;
  changed();
  const DepthMaps alone = *renderer_->read_depth();
  std::size_t changed = 0;
  std::size_t traces = 0;
  std::size_t averaged = 0;
  for (std::size_t pixel = 0; pixel < alone.smooth_mm.size(); ++pixel) {
    if (alone.smooth_mm[pixel] < 0 || before.smooth_mm[pixel] < 0) continue;
    const double from_alone_mm = std::abs(moved.smooth_mm[pixel] - alone.smooth_mm[pixel]);
    // Where the ball is, and where it was.
    const bool has_changed = std::abs(alone.smooth_mm[pixel] - before.smooth_mm[pixel]) > 1;
    changed += has_changed ? 1 : 0;
    traces += has_changed && from_alone_mm > 0.1 ? 1 : 0;
    averaged += !has_changed && from_alone_mm > 0.02 ? 1 : 0;
  }
  EXPECT_GT(changed, 200U);
  EXPECT_LT(traces, changed / 50);
  EXPECT_GT(averaged, alone.smooth_mm.size() / 4) << "the waves";
}

TEST_F(SteadyTest, StartsAgainForAnotherSurfaceAndNotForAnotherView) {
  for (int number = 0; number < 4; ++number) shown({});
  scene_.camera.yaw_deg += 5;
  EXPECT_GT(changed().stamp.mean_volumes, 2.5) << "seen from another side";
  EXPECT_GT(shown({}).stamp.mean_volumes, 2.5);
  scene_.crop.left_mm = -10;
  EXPECT_GT(changed().stamp.mean_volumes, 2.5) << "cropped";
  scene_.glass.amount = 0.5;
  EXPECT_GT(changed().stamp.mean_volumes, 2.5) << "of glass";
  scene_.detector.threshold = 40;
  EXPECT_EQ(changed().stamp.mean_volumes, 1) << "found by another threshold";
  EXPECT_GT(shown({}).stamp.mean_volumes, 1) << "the next volume is found by the same";
}

TEST_F(SteadyTest, TakesNothingFromAnotherPlace) {
  for (int number = 0; number < 3; ++number) shown({});
  EXPECT_EQ(shown({.body_right = 20, .body_deeper = -14}).stamp.mean_volumes, 1);
}

TEST_F(SteadyTest, ShowsEachVolumeOfTheCineAlone) {
  for (int number = 0; number < 8; ++number) shown({});
  for (const std::uint32_t volume : {3U, 2U, 5U}) {
    number_ = volume - 1;
    EXPECT_EQ(shown({}, Renderer::Loading::kKept).stamp.steady_share, 0);
  }
  number_ = 8;
  EXPECT_EQ(shown({}).stamp.mean_volumes, 1) << "the first after the cine";
  EXPECT_GT(shown({}).stamp.mean_volumes, 1.5);
}

TEST_F(SteadyTest, KeepsWhatItHasWhereAVolumeIsLoadedAgainAndCountsItOnce) {
  shown({});
  --number_;
  EXPECT_EQ(shown({}, Renderer::Loading::kAgain).stamp.steady_share, 0);
  for (int number = 0; number < 3; ++number) shown({});
  const double mean = shown({}).stamp.mean_volumes;
  --number_;
  EXPECT_NEAR(shown({}, Renderer::Loading::kAgain).stamp.mean_volumes, mean, 0.3);
}

TEST_F(SteadyTest, KeepsWhatItHasWhereADisplayFreezesTheVolumeBefore) {
  for (int number = 0; number < 4; ++number) shown({});
  number_ -= 2;
  EXPECT_GT(shown({}, Renderer::Loading::kKept).stamp.mean_volumes, 2.5);
  scene_.camera.yaw_deg += 4;
  EXPECT_GT(changed().stamp.mean_volumes, 2.5) << "turned";
  --number_;
  EXPECT_GT(shown({}, Renderer::Loading::kKept).stamp.mean_volumes, 2) << "loaded again for another client";
}

TEST_F(SteadyTest, CountsNothingWhereAllBendsAndNothingIsAtRest) {
  const auto bent = [&](double mm) {
    Volume volume = made_volume(kGeometry, sweep_rad(), [=](const Point& at) {
      const double wave = 40 + mm * std::sin(at.x_mm / 3) * std::cos(at.z_mm / 3);
      return at.y_mm > wave ? 150 : 10;
    });
    volume.stamp().volume_id = ++number_;
    if (auto loaded = renderer_->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    return next_picture(*renderer_);
  };
  bent(-3);
  EXPECT_LT(bent(3).stamp.steady_share, 0.3);
}

TEST_F(SteadyTest, HasNoMapInATinyOrAbsentViewport) {
  shown({});
  for (const Mode mode : {Mode::kSlice, Mode::kSlices, Mode::kMaximum}) {
    scene_.mode = mode;
    changed();
    for (int number = 0; number < 2; ++number) shown({});
  }
  EXPECT_EQ(shown({}).stamp.steady_share, 0);
}

}  // namespace
}  // namespace fanlight::test::steady_tests
