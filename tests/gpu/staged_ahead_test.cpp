// SPDX-License-Identifier: Apache-2.0
// Frames of the next volume that are staged and prepared in the middle of a cast, by shaders: a processor
// that runs all passes itself gains nothing from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::staged_ahead_tests {
namespace {

constexpr const FanGeometry& kGeometry = kSmallFan;
constexpr std::int64_t kSecondNs = 1'000'000'000;

class StagedAheadTest : public GpuTest {
 protected:
  static constexpr std::uint32_t kFrames = 11;

  StagedAheadTest() {
    scene_.speckle.filter = SpeckleFilter::kNone;
    scene_.rays.step_mm = 0.05;  // many samples, so that a processor casts in several bands
  }

  /// A ball at a place that depends on the number. Each frame has a commit number of its own.
  Volume volume(std::uint64_t number) const {
    const double right_mm = number % 2 == 0 ? 8 : -8;
    const Volume ball = made_volume(kGeometry, angles_rad_, [right_mm](const Point& at) {
      return std::hypot(at.x_mm - right_mm, at.y_mm - 60, at.z_mm) < 15 ? 120.0 : 5.0;
    });
    Volume made(kGeometry, kFrames);
    for (std::uint32_t index = 0; index < kFrames; ++index) {
      std::ranges::copy(ball.frame_pixels(index), made.next_frame_pixels().begin());
      made.add_frame(stamp(number, index));
    }
    made.sort_by_angle();
    made.stamp().volume_id = number;
    return made;
  }
  FrameStamp stamp(std::uint64_t number, std::uint32_t index) const {
    return {.sequence = number * kFrames + index,
            .frame_index = index,
            .angle_rad = angles_rad_[index],
            .commit_number = number * kFrames + index};
  }

  std::unique_ptr<Renderer> renderer() {
    return made_renderer(kGeometry, angles_rad_, {128, 128}, scene_, counters_, {.rays_by_shader = true});
  }

  /// Loads volume 1, shows it, and begins to cast volume 2, so that the renderer takes frames of volume 3.
  std::unique_ptr<Renderer> casting_the_second() {
    auto made = renderer();
    for (const std::uint64_t number : {1U, 2U}) {
      EXPECT_TRUE(made->load(volume(number)));
      if (number == 1) next_picture(*made);
    }
    EXPECT_TRUE(made->wants_frame());
    return made;
  }

  void take(Renderer& renderer, const Volume& next, std::uint64_t number, std::uint32_t frames) const {
    for (std::uint32_t index = 0; index < frames; ++index)
      renderer.take_frame(
          {.stamp = stamp(number, index), .geometry = kGeometry, .pixels = next.frame_pixels(index)});
  }

  /// Until the next volume can be loaded; its pass 1 has not begun then.
  static void end_cast(Renderer& renderer, Renderer::NextVolume next) {
    while (!renderer.wants_volume()) {
      ASSERT_TRUE(renderer.advance(Renderer::NewWork::kBegins, next));
      ASSERT_TRUE(renderer.wants_volume() || renderer.wait(kSecondNs));
    }
  }

  static double prepare_ms(const Picture& picture) {
    return picture.stamp.stage_ms[static_cast<std::size_t>(Stage::kPrepare)];
  }

  const std::vector<double> angles_rad_ = {-0.5, -0.4, -0.3, -0.2, -0.1, 0, 0.1, 0.2, 0.3, 0.4, 0.5};
  Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  RenderCounters counters_;
};

TEST_F(StagedAheadTest, ArePreparedBeforeTheCastEnds) {
  if (gpu().candidate().kind != kProcessorKind) GTEST_SKIP() << "a GPU casts in one band";
  const auto tested = casting_the_second();
  const Volume third = volume(3);
  take(*tested, third, 3, kFrames);
  end_cast(*tested, Renderer::NextVolume::kWaits);
  ASSERT_TRUE(tested->load(third));
  EXPECT_EQ(next_picture(*tested).stamp.volume.volume_id, 2U);
  EXPECT_EQ(prepare_ms(next_picture(*tested)), 0);
}

TEST_F(StagedAheadTest, AreNotPreparedWhereNoVolumeWaits) {
  const auto tested = casting_the_second();
  const Volume third = volume(3);
  take(*tested, third, 3, kFrames);
  end_cast(*tested, Renderer::NextVolume::kUnknown);
  ASSERT_TRUE(tested->load(third));
  EXPECT_EQ(next_picture(*tested).stamp.volume.volume_id, 2U);
  EXPECT_GT(prepare_ms(next_picture(*tested)), 0);
}

TEST_F(StagedAheadTest, LeaveBothPicturesAsTheyAre) {
  const auto tested = casting_the_second();
  const auto plain = renderer();
  take(*tested, volume(3), 3, kFrames);
  end_cast(*tested, Renderer::NextVolume::kWaits);
  ASSERT_TRUE(tested->load(volume(3)));
  for (const std::uint64_t number : {2U, 3U}) {
    ASSERT_TRUE(plain->load(volume(number)));
    EXPECT_EQ(next_picture(*tested).rgba, next_picture(*plain).rgba) << "volume " << number;
  }
}

TEST_F(StagedAheadTest, AreReplacedByThoseOfANewerVolume) {
  const auto tested = casting_the_second();
  const auto plain = renderer();
  take(*tested, volume(3), 3, kFrames);
  end_cast(*tested, Renderer::NextVolume::kWaits);
  ASSERT_TRUE(tested->load(volume(4)));
  EXPECT_EQ(next_picture(*tested).stamp.volume.volume_id, 2U);
  ASSERT_TRUE(plain->load(volume(4)));
  EXPECT_EQ(next_picture(*tested).rgba, next_picture(*plain).rgba);
}

}  // namespace
}  // namespace fanlight::test::staged_ahead_tests
