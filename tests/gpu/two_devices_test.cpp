// SPDX-License-Identifier: Apache-2.0
// Passes 2 and 3 on a processor: as shaders on a device of their own, where they run beside pass 1 of the
// next volume, and in C++.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <ostream>
#include <vector>

#include "proto/model/look.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::two_devices_tests {
namespace {

constexpr const FanGeometry& kGeometry = kSmallFan;
constexpr PictureSize kSize{128, 128};
constexpr std::int64_t kSecondNs = 1'000'000'000;

/// Waves, of more contrast on one side than on the other.
double relief(const Point& at) {
  const double surface_mm = 50 + 4 * std::sin(at.x_mm / 5) * std::cos(at.z_mm / 7);
  return at.y_mm > surface_mm ? 90 + at.x_mm + 20 * std::sin(at.x_mm) : 5;
}

constexpr Casting kTwoDevices = {.rays_by_shader = true};
constexpr Casting kOneDevice = {.rays_by_shader = true, .own_light_device = false};
constexpr Casting kHere = {};  // passes 1 to 3 in C++

/// The same with whole pictures.
constexpr Casting whole_pictures(Casting casting) {
  casting.skipping = Skipping::kOff;
  return casting;
}

class TwoDevicesTest : public GpuTest {
 protected:
  void SetUp() override {
    if (gpu().candidate().kind != kProcessorKind) GTEST_SKIP() << "for processors only";
  }

  std::unique_ptr<Renderer> renderer(const Scene& scene, const Casting& casting) {
    return made_renderer(kGeometry, angles_rad_, kSize, scene, counters_, casting);
  }
  Volume volume(std::uint64_t number) const {
    Volume made = made_volume(kGeometry, angles_rad_, relief);
    made.stamp().volume_id = number;
    return made;
  }

  const std::vector<double> angles_rad_ = {-0.5, -0.4, -0.3, -0.2, -0.1, 0, 0.1, 0.2, 0.3, 0.4, 0.5};
  const Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  RenderCounters counters_;
};

/// Whether passes 2 and 3 of some volume ran while pass 1 of the next one did. Pass 1 is a single band here,
/// within which one device runs nothing else.
bool overlaps(Renderer& renderer, const std::function<Volume(std::uint64_t)>& volume) {
  constexpr std::uint64_t kVolumes = 40;
  StageSpan last_light;
  bool found = false;
  std::uint64_t loaded = 0;
  for (std::uint64_t shown = 0; shown < kVolumes;) {
    if (loaded < kVolumes && renderer.wants_volume()) {
      EXPECT_TRUE(renderer.load(volume(++loaded)));
    }
    EXPECT_TRUE(renderer.advance());
    Picture picture;
    if (!renderer.collect(picture)) {
      const bool more = loaded < kVolumes && renderer.wants_volume();
      EXPECT_TRUE(more || renderer.wait(kSecondNs));
      continue;
    }
    shown = picture.stamp.volume.volume_id;
    const auto spans = renderer.stage_spans();
    const StageSpan cast = spans[static_cast<std::size_t>(Stage::kCast)];
    found |= last_light.begin_ns < cast.end_ns && cast.begin_ns < last_light.end_ns;
    last_light = {.begin_ns = spans[static_cast<std::size_t>(Stage::kFilter)].begin_ns,
                  .end_ns = spans[static_cast<std::size_t>(Stage::kFinish)].end_ns};
  }
  return found;
}

TEST_F(TwoDevicesTest, LightOneVolumeWhileTheNextIsCast) {
  Scene scene = scene_;
  scene.rays.step_mm = 0.5;
  scene.filter.kind = DepthFilter::kEdgePreserving;
  scene.filter.size = 31;
  scene.finish.smoothing = Smoothing::kDiffusion;
  scene.finish.iterations = 30;
  // Each slot gets another volume than it had, so that passes 2 and 3 have all of it to do.
  const auto next = [this](std::uint64_t number) {
    Volume made = made_volume(kGeometry, angles_rad_, [number](const Point& at) {
      return relief({at.x_mm + 3.0 * static_cast<double>(number % 3), at.y_mm, at.z_mm});
    });
    made.stamp().volume_id = number;
    return made;
  };
  // Where the processor casts and lights, both are done by the same threads in turn.
  EXPECT_TRUE(overlaps(*renderer(scene, kTwoDevices), next));
  EXPECT_FALSE(overlaps(*renderer(scene, kOneDevice), next)) << "one device takes turns";
}

struct Way {
  const char* name;
  Casting casting;
};
void PrintTo(const Way& way, std::ostream* out) {
  *out << way.name;
}

/// Where a new volume does not keep the light waiting.
class MovedLightTest : public TwoDevicesTest, public testing::WithParamInterface<Way> {
 protected:
  std::unique_ptr<Renderer> tested() { return renderer(scene_, GetParam().casting); }
};

INSTANTIATE_TEST_SUITE_P(Ways, MovedLightTest,
                         testing::Values(Way{"shaders", kTwoDevices}, Way{"C++", kHere}));

TEST_P(MovedLightTest, NeedsNoOtherCast) {
  const auto moving = tested();
  ASSERT_TRUE(moving->load(volume(1)));
  const Picture first = next_picture(*moving);
  EXPECT_GT(first.stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)], 0);
  const auto casts = counters_.pass1_runs.value();
  Scene moved = scene_;
  moved.light.right_mm += 40;
  moving->show({.revision = 2, .scene = moved});
  const Picture second = next_picture(*moving);
  EXPECT_NE(second.rgba, first.rgba);
  EXPECT_EQ(second.stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)], 0);
  EXPECT_EQ(counters_.pass1_runs.value(), casts);
}

/// Loads a volume and returns when the filter of its picture has begun, and its light has not.
void begin_filter(Renderer& renderer, const RenderCounters& counters, const Volume& volume) {
  const auto lit = counters.pass2_runs.value();
  ASSERT_TRUE(renderer.load(volume));
  while (counters.pass2_runs.value() == lit) {
    ASSERT_TRUE(renderer.advance());
    ASSERT_TRUE(counters.pass2_runs.value() > lit || renderer.wait(kSecondNs));
  }
}

TEST_P(MovedLightTest, IsInThePictureWhoseFilterIsUnderWay) {
  Scene moved = scene_;
  moved.light.right_mm += 40;
  const auto moving = tested();
  begin_filter(*moving, counters_, volume(1));
  moving->show({.revision = 2, .scene = moved});
  const Picture picture = next_picture(*moving);
  EXPECT_EQ(picture.stamp.scene_revision, 2U);
  EXPECT_EQ(counters_.pass2_runs.value(), 1U);
  EXPECT_GT(picture.stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)], 0);

  const auto still = renderer(moved, GetParam().casting);
  ASSERT_TRUE(still->load(volume(1)));
  EXPECT_EQ(picture.rgba, next_picture(*still).rgba);
}

TEST_P(MovedLightTest, LetsAPictureEndWhoseFilterChangesWithoutRest) {
  Scene scene = scene_;
  const auto moving = tested();
  begin_filter(*moving, counters_, volume(1));
  Picture picture;
  std::uint64_t revision = 1;
  while (!moving->collect(picture)) {
    scene.filter.size = scene.filter.size == 9 ? 11 : 9;
    moving->show({.revision = ++revision, .scene = scene});
    ASSERT_TRUE(moving->advance());
    ASSERT_TRUE(moving->wait(kSecondNs));
    ASSERT_LT(revision, 100U) << "the picture is begun again and again";
  }
  EXPECT_EQ(picture.stamp.scene_revision, 1U);
  EXPECT_EQ(next_picture(*moving).stamp.scene_revision, revision);
}

TEST_F(TwoDevicesTest, WeighByConfidenceAsOneDeviceDoes) {
  Scene weighed = scene_;
  weighed.filter.weights = FilterWeights::kConfidence;
  std::array<Picture, 2> pictures;
  for (const bool apart : {false, true}) {
    const auto tested = renderer(scene_, apart ? kTwoDevices : kOneDevice);
    ASSERT_TRUE(tested->load(volume(1)));
    const Picture uniform = next_picture(*tested);
    // On a picture at rest, whose weights no one has computed.
    tested->show({.revision = 2, .scene = weighed});
    pictures[apart ? 1 : 0] = next_picture(*tested);
    EXPECT_EQ(pictures[apart ? 1 : 0].stamp.scene_revision, 2U);
    EXPECT_NE(pictures[apart ? 1 : 0].rgba, uniform.rgba);
    EXPECT_FALSE(tested->read_depth()->confidence.empty());
    // And for the next volume, from the start.
    ASSERT_TRUE(tested->load(volume(2)));
    EXPECT_EQ(next_picture(*tested).rgba, pictures[apart ? 1 : 0].rgba);
  }
  EXPECT_EQ(pictures[0].rgba, pictures[1].rgba);
}

/// Passes 2 and 3 of a scene where one frame after another is replaced.
struct PartlyLit {
  const char* name;
  void (*change)(Scene& scene);
};

void PrintTo(const PartlyLit& given, std::ostream* to) {
  *to << given.name;
}

class PartlyLitTest : public TwoDevicesTest, public testing::WithParamInterface<PartlyLit> {
 protected:
  static constexpr std::uint32_t kFrames = 11;

  /// Another relief where `newer` says so, by ascending angle. A frame has one commit number in every volume.
  Volume mixed(const std::vector<bool>& newer) const {
    Volume made(kGeometry, kFrames);
    for (std::uint32_t index = 0; index < kFrames; ++index) {
      const QueuedFrame frame = queued_frame(index, newer[index]);
      std::ranges::copy(frame.pixels, made.next_frame_pixels().begin());
      made.add_frame(frame.stamp);
    }
    made.sort_by_angle();
    made.stamp().volume_id = 1;
    return made;
  }

  QueuedFrame queued_frame(std::uint32_t index, bool newer) const {
    return {.stamp = {.sequence = index + (newer ? kFrames : 0U),
                      .angle_rad = angles_rad_[index],
                      .commit_number = 1 + index + (newer ? kFrames : 0U)},
            .geometry = kGeometry,
            .pixels = (newer ? second_ : first_).frame_pixels(index)};
  }

  void compare_with_whole_pictures(const Casting& casting);

  const Volume first_ = made_volume(kGeometry, angles_rad_, relief);
  const Volume second_ = made_volume(kGeometry, angles_rad_, [](const Point& at) {
    // Nearer, with a hole and an island.
    const bool in_hole = std::hypot(at.x_mm - 5, at.z_mm) < 3;
    const bool in_island = std::hypot(at.x_mm + 9, at.z_mm - 2) < 2 && at.y_mm > 35;
    return in_island || (!in_hole && relief({at.x_mm, at.y_mm + 3, at.z_mm}) > 50) ? 95.0 : 5.0;
  });
};

void PartlyLitTest::compare_with_whole_pictures(const Casting& casting) {
  Scene scene = scene_;
  scene.refresh = Refresh::kFrame;
  // Not from the data, which have other levels with each frame.
  scene.detector.threshold = 40;
  scene.detector.rise = 0.7;
  scene.detector.least_tissue = 50;
  scene.detector.least_contrast = 20;
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.filter.size_mm = 0;
  scene.filter.step_mm = 2;
  scene.filter.seam_frames = 0;  // a picture of a whole volume knows none before it (seam_test.cpp)
  ASSERT_TRUE(apply_look(scene, "paper"));
  GetParam().change(scene);
  std::vector<bool> newer(kFrames, false);
  const auto lit_in_parts_before = counters_.pass2_parts.value();
  const auto parts = renderer(scene, casting);
  ASSERT_TRUE(parts->load(mixed(newer)));
  next_picture(*parts);
  scene.refresh = Refresh::kVolume;
  const auto whole = renderer(scene, whole_pictures(casting));
  for (std::uint32_t index = 0; index < kFrames; ++index) {
    ASSERT_TRUE(parts->wants_frame());
    parts->take_frame(queued_frame(index, true));
    newer[index] = true;
    const Picture part = next_picture(*parts);
    Volume same = mixed(newer);
    same.stamp().volume_id = 2 + index;
    ASSERT_TRUE(whole->load(same));
    const Picture afresh = next_picture(*whole);
    ASSERT_EQ(part.depth_mm, afresh.depth_mm) << "after frame " << index;
    ASSERT_EQ(part.rgba, afresh.rgba) << "after frame " << index;
  }
  EXPECT_GE(counters_.pass2_parts.value(), lit_in_parts_before + kFrames / 2);
  // A moved light is computed everywhere.
  const auto lit_in_parts = counters_.pass2_parts.value();
  scene.light.right_mm += 30;
  whole->show({.revision = 2, .scene = scene});
  scene.refresh = Refresh::kFrame;
  parts->show({.revision = 2, .scene = scene});
  EXPECT_EQ(next_picture(*parts).rgba, next_picture(*whole).rgba);
  EXPECT_EQ(counters_.pass2_parts.value(), lit_in_parts);
}

TEST_P(PartlyLitTest, ShowsWhatTheWholePictureShows) {
  compare_with_whole_pictures(kHere);
  compare_with_whole_pictures(kTwoDevices);
}

/// Whether a part of a picture suffices depends on how its maps were filtered last, not on what the scene has
/// asked for since.
class AfterOtherMapsTest : public PartlyLitTest {
 protected:
  void load(const Volume& volume) {
    ASSERT_TRUE(parts_->load(volume));
    ASSERT_TRUE(whole_->load(volume));
  }
  void show(std::uint64_t revision, const Scene& scene) {
    parts_->show({.revision = revision, .scene = scene});
    whole_->show({.revision = revision, .scene = scene});
  }
  void take(const QueuedFrame& frame) {
    ASSERT_TRUE(parts_->wants_frame() && whole_->wants_frame());
    parts_->take_frame(frame);
    whole_->take_frame(frame);
  }
  void compare(const char* after) {
    EXPECT_EQ(next_picture(*parts_).rgba, next_picture(*whole_).rgba) << "after " << after;
  }

  // After the same events.
  std::unique_ptr<Renderer> parts_;
  std::unique_ptr<Renderer> whole_;
};

TEST_P(AfterOtherMapsTest, ShowsWhatTheWholePictureShows) {
  Scene scene = scene_;
  scene.detector.threshold = 40;
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.filter.steady = 0.5;
  GetParam().change(scene);
  parts_ = renderer(scene, kHere);
  whole_ = renderer(scene, whole_pictures(kHere));
  load(mixed(std::vector<bool>(kFrames, false)));
  compare("a volume");
  scene.refresh = Refresh::kFrame;
  scene.light.right_mm += 5;
  show(2, scene);
  compare("a light");
  Volume second = mixed(std::vector<bool>(kFrames, true));
  second.stamp().volume_id = 2;
  load(second);
  compare("another volume, whose frames may be replaced");
  scene.refresh = Refresh::kVolume;
  scene.filter.step_mm += 1;
  show(3, scene);
  compare("a filter with the last volume");
  scene.refresh = Refresh::kFrame;
  scene.light.right_mm += 5;
  show(4, scene);
  compare("a light without the filter");
  QueuedFrame frame = queued_frame(kFrames / 2, false);
  frame.stamp.commit_number = 100;
  take(frame);
  compare("a frame");
}

INSTANTIATE_TEST_SUITE_P(Passes, AfterOtherMapsTest,
                         testing::Values(PartlyLit{"mean", [](Scene&) {}},
                                         PartlyLit{"weights", [](Scene& scene) {
                                                     scene.filter.weights = FilterWeights::kConfidence;
                                                   }}));

INSTANTIATE_TEST_SUITE_P(
    Passes, PartlyLitTest,
    testing::Values(PartlyLit{"no filter, no shadow",
                              [](Scene& scene) {
                                scene.filter.size = scene.filter.islands = scene.filter.holes = 1;
                                scene.shadow.coefficient = 1;
                              }},
                    PartlyLit{"soft light, no shadow",
                              [](Scene& scene) {
                                EXPECT_TRUE(apply_look(scene, "skin"));
                                scene.shadow.coefficient = 1;
                              }},
                    PartlyLit{"wide mean, no shadow",
                              [](Scene& scene) {
                                scene.filter.kind = DepthFilter::kMean;
                                scene.filter.size = 31;
                                scene.filter.islands = scene.filter.holes = 1;
                                scene.shadow.coefficient = 1;
                              }},
                    PartlyLit{"narrow mean, islands, holes, no shadow",
                              [](Scene& scene) {
                                scene.filter.kind = DepthFilter::kMean;
                                scene.filter.size = 3;
                                scene.filter.islands = scene.filter.holes = 15;
                                scene.shadow.coefficient = 1;
                              }},
                    PartlyLit{"narrow Gaussian, holes, no shadow",
                              [](Scene& scene) {
                                scene.filter.kind = DepthFilter::kGaussian;
                                scene.filter.size = 1;
                                scene.filter.islands = 1;
                                scene.filter.holes = 15;
                                scene.shadow.coefficient = 1;
                              }},
                    PartlyLit{"edge-preserving, weights, long shadows",
                              [](Scene& scene) {
                                scene.filter.kind = DepthFilter::kEdgePreserving;
                                scene.filter.weights = FilterWeights::kConfidence;
                                scene.light.kind = LightKind::kDirectional;
                                scene.light.up_mm = 900;
                                scene.light.right_mm = 0;
                                scene.shadow.coefficient = 0;
                                scene.shadow.softness_mm = 0;
                              }},
                    PartlyLit{"mean, diffusion, no shadow",
                              [](Scene& scene) {
                                scene.filter.kind = DepthFilter::kMean;
                                scene.shadow.coefficient = 1;
                                scene.finish.smoothing = Smoothing::kDiffusion;
                                scene.finish.iterations = 7;
                              }},
                    PartlyLit{"Gaussian, colours beside the surface, no shadow",
                              [](Scene& scene) {
                                scene.filter.kind = DepthFilter::kGaussian;
                                scene.mode = Mode::kSurfaceAndVolume;
                                scene.shadow.coefficient = 1;
                              }},
                    PartlyLit{"outlines of 3 pixels, no shadow",
                              [](Scene& scene) {
                                scene.finish.outline = 3;
                                scene.shadow.coefficient = 1;
                              }},
                    PartlyLit{"outlines of 8 pixels, no filter, no shadow", [](Scene& scene) {
                                scene.finish.outline = 8;
                                scene.filter.size = scene.filter.islands = scene.filter.holes = 1;
                                scene.shadow.coefficient = 1;
                              }}));

}  // namespace
}  // namespace fanlight::test::two_devices_tests
