// SPDX-License-Identifier: Apache-2.0
// The seam of a rolling sweep (Scene::Filter::seam_frames): the surface of the last sweep is blended into the
// new one.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "renderer/parameters/seam.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"
#include "tests/support/twin_steady.hpp"

namespace fanlight::test::seam_tests {
namespace {

constexpr const FanGeometry& kGeometry = kMapFan;
constexpr PictureSize kPicture{.width = 120, .height = 110};
constexpr std::uint32_t kFrames = 41;
constexpr double kStepRad = radians(1.3);
constexpr int kSeamFrames = 6;

std::vector<double> sweep_rad() {
  std::vector<double> angles_rad;
  for (std::uint32_t frame = 0; frame < kFrames; ++frame)
    angles_rad.push_back(kStepRad * (static_cast<double>(frame) - (kFrames - 1) / 2.0));
  return angles_rad;
}

/// Waves in fluid.
Volume waves(double deeper_mm) {
  return made_volume(kGeometry, sweep_rad(), [=](const Point& at) {
    const double surface_mm = 40 + deeper_mm + 3 * std::sin(at.x_mm / 4) + 2 * std::cos(at.z_mm / 9);
    return 90 + 80 * std::clamp((at.y_mm - surface_mm) / 1.5, -1.0, 1.0);
  });
}

/// The depth map is that of the seam.
Scene scene_of_test() {
  const auto angles_rad = sweep_rad();
  Scene scene = scene_for(kGeometry, angles_rad.front(), angles_rad.back());
  scene.camera.target = {.x_mm = 0, .y_mm = 40, .z_mm = 0};
  scene.camera.field_mm = 60;
  scene.detector = {.threshold = 30};
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.filter = {.size = 1, .step_mm = 4, .islands = 1, .holes = 1, .seam_frames = kSeamFrames};
  scene.refresh = Refresh::kFrame;
  return scene;
}

struct Shown {
  Picture picture;
  DepthMaps maps;
};

class SeamTest : public GpuTest {
 protected:
  std::unique_ptr<Renderer> renderer(const Scene& scene, Skipping skipping = Skipping::kOn) {
    return made_renderer(kGeometry, sweep_rad(), kPicture, scene, counters_, {.skipping = skipping});
  }
  QueuedFrame frame_of(const Volume& sweep, std::uint32_t index) {
    return {.stamp = {.sequence = commits_, .angle_rad = sweep_rad()[index], .commit_number = ++commits_},
            .geometry = kGeometry,
            .pixels = sweep.frame_pixels(index)};
  }
  static Shown shown(Renderer& renderer) {
    Shown now{.picture = next_picture(renderer), .maps = {}};
    now.maps = *renderer.read_depth();
    return now;
  }
  /// How much the middle column has moved at most from one row to that four rows below, beside its first
  /// picture.
  static double ridge_mm(const Shown& shown, const Shown& first) {
    constexpr std::uint32_t kRows = 4;
    const auto moved_mm = [&](std::uint32_t row) {
      const std::size_t pixel = std::size_t{row} * kPicture.width + kPicture.width / 2;
      return double{shown.maps.smooth_mm[pixel]} - first.maps.smooth_mm[pixel];
    };
    double most = 0;
    for (std::uint32_t row = 20; row + 20 < kPicture.height; ++row)
      most = std::max(most, std::abs(moved_mm(row + kRows) - moved_mm(row)));
    return most;
  }

  const Volume first_ = waves(0);
  const Volume second_ = waves(1.5);
  RenderCounters counters_;
  std::uint64_t commits_ = kFrames;
};

TwinSteadyMap single(const Scene& scene, const Shown& shown) {
  return twin_single(scene, kPicture, {shown.maps.cast_mm.begin(), shown.maps.cast_mm.end()});
}

double difference_mm(const Shown& shown, const TwinSteadyMap& twin) {
  double most = 0;
  for (std::size_t pixel = 0; pixel < twin.depth_mm.size(); ++pixel) {
    EXPECT_EQ(shown.maps.smooth_mm[pixel] < 0, twin.depth_mm[pixel] < 0);
    if (twin.depth_mm[pixel] >= 0)
      most = std::max(most, std::abs(shown.maps.smooth_mm[pixel] - twin.depth_mm[pixel]));
  }
  return most;
}

/// Several frames come between two pictures, and the view turns between two others.
TEST_F(SeamTest, IsWhatTheTwinSays) {
  Scene scene = scene_of_test();
  const auto tested = renderer(scene);
  ASSERT_TRUE(tested->load(first_));
  TwinSteadyMap twin = single(scene, shown(*tested));
  std::uint32_t came = 0;
  for (const std::uint32_t more : {1U, 1U, 1U, 2U, 3U, 1U, 4U, 1U, 8U, 2U}) {
    for (std::uint32_t frame = 0; frame < more; ++frame)
      tested->take_frame(frame_of(second_, kFrames - 1 - came++));
    if (more == 4) {
      scene.camera.yaw_deg += 5;
      scene.camera.pitch_deg -= 3;
      tested->show({.revision = 2, .scene = scene});
    }
    const Shown now = shown(*tested);
    EXPECT_EQ(now.picture.stamp.seam_frames, kSeamFrames);
    std::vector<TwinNewFrame> frames;
    for (std::uint32_t newer = 0; newer < std::min<std::uint32_t>(came, kSeamFrames); ++newer) {
      const double share = (kSeamFrames - newer) / (kSeamFrames + 1.0);
      const double before = newer < more ? 1 : (kSeamFrames - (newer - more)) / (kSeamFrames + 1.0);
      frames.push_back({sweep_rad()[kFrames - came + newer], share, before});
    }
    twin = twin_seam(single(scene, now), twin, kGeometry, frames, kStepRad);
    EXPECT_LT(difference_mm(now, twin), 0.005) << came << " frames";
  }
}

TEST_F(SeamTest, MakesTheRidgeAtLeastThreeTimesLower) {
  Scene scene = scene_of_test();
  const auto last_ridge_mm = [&](int seam_frames) {
    scene.filter.seam_frames = seam_frames;
    const auto tested = renderer(scene);
    EXPECT_TRUE(tested->load(first_));
    const Shown first = shown(*tested);
    double ridge = 0;
    for (std::uint32_t index = 0; index < kFrames / 2; ++index) {
      tested->take_frame(frame_of(second_, index));
      ridge = ridge_mm(shown(*tested), first);
    }
    return ridge;
  };
  const double at_once_mm = last_ridge_mm(0);
  EXPECT_GT(at_once_mm, 1.2) << "there is no ridge to blend";
  EXPECT_LT(last_ridge_mm(kSeamFrames), at_once_mm / 3);
}

TEST_F(SeamTest, LeavesWhatDoesNotMoveAsItIs) {
  Scene scene = scene_of_test();
  const auto blending = renderer(scene);
  scene.filter.seam_frames = 0;
  const auto at_once = renderer(scene);
  for (auto* const each : {blending.get(), at_once.get()}) {
    ASSERT_TRUE(each->load(first_));
    next_picture(*each);
  }
  for (std::uint32_t index = 0; index < 12; ++index) {
    const QueuedFrame frame = frame_of(first_, index);
    blending->take_frame(frame);
    at_once->take_frame(frame);
    const Picture blended = next_picture(*blending);
    const Picture whole = next_picture(*at_once);
    ASSERT_EQ(blended.depth_mm, whole.depth_mm);
    ASSERT_EQ(blended.rgba, whole.rgba);
    EXPECT_EQ(blended.stamp.seam_frames, kSeamFrames);
    EXPECT_EQ(whole.stamp.seam_frames, 0);
  }
}

TEST_F(SeamTest, IsGoneBehindTheSeam) {
  const Scene scene = scene_of_test();
  const auto tested = renderer(scene);
  ASSERT_TRUE(tested->load(first_));
  next_picture(*tested);
  Shown end;
  for (std::uint32_t index = 0; index < kFrames; ++index) {
    tested->take_frame(frame_of(second_, index));
    end = shown(*tested);
  }
  EXPECT_NE(end.maps.smooth_mm, end.maps.cast_mm) << "the last frames are blended";
  // The motor turns, and the last frames come again: nothing differs from the last sweep any more.
  Shown now;
  for (std::uint32_t index = kFrames - 1; index + 2 * kSeamFrames >= kFrames - 1; --index) {
    tested->take_frame(frame_of(second_, index));
    now = shown(*tested);
  }
  EXPECT_EQ(now.maps.smooth_mm, now.maps.cast_mm);
}

/// One of the cine, of a frozen display.
TEST_F(SeamTest, AKeptVolumeIsShownAlone) {
  const auto tested = renderer(scene_of_test());
  ASSERT_TRUE(tested->load(first_));
  next_picture(*tested);
  for (std::uint32_t index = 0; index < kFrames / 2; ++index) {
    tested->take_frame(frame_of(second_, index));
    next_picture(*tested);
  }
  ASSERT_TRUE(tested->load(first_, Renderer::Loading::kKept));
  const Shown kept = shown(*tested);
  EXPECT_EQ(kept.picture.stamp.seam_frames, 0);
  EXPECT_EQ(kept.maps.smooth_mm, kept.maps.cast_mm);
}

/// A sweep of which some frames came with the whole volume only, as on a machine that is late.
TEST_F(SeamTest, BlendsFramesThatComeWithTheirVolume) {
  const auto tested = renderer(scene_of_test());
  ASSERT_TRUE(tested->load(first_));
  const Shown before = shown(*tested);
  Volume whole(kGeometry, kFrames);
  for (std::uint32_t index = 0; index < kFrames; ++index) {
    const QueuedFrame frame = frame_of(second_, index);
    std::ranges::copy(frame.pixels, whole.next_frame_pixels().begin());
    whole.add_frame(frame.stamp);
    if (index + 3 >= kFrames) continue;
    tested->take_frame(frame);
    next_picture(*tested);
  }
  whole.sort_by_angle();
  whole.stamp().volume_id = 2;
  ASSERT_TRUE(tested->load(whole));
  const Shown now = shown(*tested);
  EXPECT_EQ(now.picture.stamp.volume.volume_id, 2U);
  EXPECT_EQ(now.picture.stamp.seam_frames, kSeamFrames);
  EXPECT_LT(ridge_mm(now, before), 0.6);
  EXPECT_NE(now.maps.smooth_mm, now.maps.cast_mm);
  // The same volume, frozen.
  ASSERT_TRUE(tested->load(whole, Renderer::Loading::kKept));
  const Shown kept = shown(*tested);
  EXPECT_EQ(kept.picture.stamp.seam_frames, 0);
  EXPECT_EQ(kept.maps.smooth_mm, kept.maps.cast_mm);
}

class SeamPartsTest : public SeamTest, public testing::WithParamInterface<int> {};

TEST_P(SeamPartsTest, AreThoseOfTheWholePicture) {
  if (gpu().candidate().kind != kProcessorKind) GTEST_SKIP() << "for processors only";
  Scene scene = scene_of_test();
  scene.filter.seam_frames = GetParam();
  scene.filter.size = 5;
  const auto parts = renderer(scene);
  const auto whole = renderer(scene, Skipping::kOff);
  for (auto* const each : {parts.get(), whole.get()}) {
    ASSERT_TRUE(each->load(first_));
    next_picture(*each);
  }
  // To and fro: the motor turns in the picture.
  for (std::uint32_t number = 0; number < 2 * kFrames - 20; ++number) {
    const bool back = number >= kFrames - 10;
    const QueuedFrame frame =
        frame_of(back ? first_ : second_, back ? 2 * (kFrames - 10) - 1 - number : number);
    parts->take_frame(frame);
    whole->take_frame(frame);
    // A moved light between frames computes no map.
    if (number == 9 || number == 10) {
      scene.light.right_mm += 10;
      parts->show({.revision = number, .scene = scene});
      whole->show({.revision = number, .scene = scene});
    }
    const Picture part = next_picture(*parts);
    const Picture all = next_picture(*whole);
    ASSERT_EQ(part.depth_mm, all.depth_mm) << "after frame " << number;
    ASSERT_EQ(part.rgba, all.rgba) << "after frame " << number;
  }
  EXPECT_GE(counters_.pass2_parts.value(), GetParam() > kSeamFrames ? 1 : kFrames / 2);
}

INSTANTIATE_TEST_SUITE_P(Frames, SeamPartsTest, testing::Values(1, kSeamFrames, FANLIGHT_MOST_SEAM_FRAMES));

TEST_F(SeamTest, StartsAgainForASurfaceThatIsFoundElsewhere) {
  Scene scene = scene_of_test();
  const auto tested = renderer(scene);
  ASSERT_TRUE(tested->load(first_));
  next_picture(*tested);
  for (std::uint32_t index = 0; index < 3; ++index) {
    tested->take_frame(frame_of(second_, index));
    next_picture(*tested);
  }
  scene.detector.threshold += 10;
  tested->show({.revision = 2, .scene = scene});
  const Shown now = shown(*tested);
  EXPECT_EQ(now.picture.stamp.seam_frames, 0);
  EXPECT_EQ(now.maps.smooth_mm, now.maps.cast_mm);
  // A crop box shows what lies behind: nothing of the picture before is blended into it.
  tested->take_frame(frame_of(second_, 3));
  EXPECT_EQ(shown(*tested).picture.stamp.seam_frames, kSeamFrames);
  scene.crop.near_mm = 39;
  tested->show({.revision = 3, .scene = scene});
  EXPECT_EQ(shown(*tested).picture.stamp.seam_frames, 0);
  scene.refresh = Refresh::kVolume;
  tested->show({.revision = 4, .scene = scene});
  ASSERT_TRUE(tested->load(second_));
  Shown last = shown(*tested);
  while (last.picture.stamp.scene_revision < 4) last = shown(*tested);
  EXPECT_EQ(last.picture.stamp.seam_frames, 0);
  EXPECT_EQ(last.maps.smooth_mm, last.maps.cast_mm);
}

}  // namespace
}  // namespace fanlight::test::seam_tests
