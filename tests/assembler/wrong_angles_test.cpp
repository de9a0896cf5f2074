// SPDX-License-Identifier: Apache-2.0
// Frames whose angle is apart from their neighbours', sweeps with a gap in their angles, and the record of
// sweeps that gave no volume.
#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

class WrongAnglesTest : public AssemblerTest {
 protected:
  static constexpr std::uint32_t kFrames = 40;

  WrongAnglesTest() : AssemblerTest(Set{.capacity = kFrames}) {}

  /// A sweep in which the frames from `first` to before `end` have an angle of their own.
  void add_sweep_with(std::uint32_t first, std::uint32_t end, double angle_deg) {
    for (std::uint32_t i = 0; i < kFrames; ++i) {
      FrameStamp stamp = frame(0, i, kFrames);
      if (i >= first && i < end) stamp.angle_rad = radians(angle_deg);
      add(stamp);
    }
  }
  std::optional<DroppedSweep> dropped() { return dropped_.take(); }
};

TEST_F(WrongAnglesTest, OneWrongAngleIsInvalidAndItsNeighboursStandIn) {
  add_sweep_with(17, 18, -80);
  EXPECT_EQ(counters_.frames_invalid.value(), 1U);
  EXPECT_EQ(counters_.volumes_interpolated.value(), 1U);
  EXPECT_EQ(sum_of_fates(counters_), counters_.frames_received.value());
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->stamp().frames, kFrames - 1);
  EXPECT_EQ(volume->stamp().frames_missing, 1U);
  double last_rad = -1;
  for (const std::uint32_t index : volume->by_angle()) {
    EXPECT_GT(volume->angles_rad()[index], last_rad);
    last_rad = volume->angles_rad()[index];
    // Each frame still has its own pixels: every pixel is the sequence number.
    EXPECT_NEAR(degrees(last_rad), 2.0 * volume->frame_pixels(index)[0], 1e-9);
    EXPECT_NE(volume->frame_pixels(index)[0], 17);
  }
  EXPECT_EQ(volume->stamp().first_frame_sequence, 0U);
  EXPECT_EQ(volume->stamp().last_frame_sequence, kFrames - 1);
}

TEST_F(WrongAnglesTest, AWrongLastAngleEndsTheVolumeBeforeIt) {
  add_sweep_with(kFrames - 1, kFrames, -80);
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->stamp().last_frame_sequence, kFrames - 2);
  EXPECT_EQ(volume->stamp().last_capture_time_ns, 1000 * (kFrames - 1));
}

TEST_F(WrongAnglesTest, AGapInTheAnglesThatNoNumberTellsDropsTheSweep) {
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    FrameStamp stamp = frame(0, i, kFrames);
    if (i < 20) stamp.angle_rad -= radians(30);
    add(stamp);
  }
  EXPECT_EQ(counters_.volumes_incomplete.value(), 1U);
  EXPECT_EQ(counters_.frames_in_incomplete_volumes.value(), kFrames);
  EXPECT_EQ(sum_of_fates(counters_), counters_.frames_received.value());
  EXPECT_FALSE(ring_.take());
  const auto sweep = dropped();
  ASSERT_TRUE(sweep);
  EXPECT_EQ(reason_of(*sweep),
            "its angle jumps by 32.00 deg between two frames, expected at most five usual steps of 2.00 deg");
}

TEST_F(WrongAnglesTest, TheRecordTellsWhyASweepWasDropped) {
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    const FrameStamp stamp = frame(3, i, kFrames);
    if (i % 4 != 1) add(stamp);
  }
  const auto thinned = dropped();
  ASSERT_TRUE(thinned);
  EXPECT_EQ(thinned->volume_index, 3U);
  EXPECT_EQ(reason_of(*thinned), "10 of its 40 frames are missing or not usable, expected 15 % at most");
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    FrameStamp stamp = frame(4, i, kFrames);
    stamp.angle_rad = 0.1;
    add(stamp);
  }
  const auto still = dropped();
  ASSERT_TRUE(still);
  EXPECT_EQ(reason_of(*still), "the angle of its 40 frames does not move, expected a sweep");
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    const FrameStamp stamp = frame(6, i, kFrames);
    if (i < 10 || i >= 14) add(stamp);
  }
  const auto gap = dropped();
  ASSERT_TRUE(gap);
  EXPECT_EQ(reason_of(*gap), "4 frames in a row are missing or not usable, expected 3 at most");
  EXPECT_FALSE(dropped());
}

TEST(DroppedSweepsTest, ForgetsWhatNobodyTakes) {
  DroppedSweeps sweeps;
  for (std::uint64_t index = 0; index < 1000; ++index) sweeps.put({.volume_index = index});
  for (std::uint64_t index = 0; index < 256; ++index) EXPECT_EQ(sweeps.take()->volume_index, index);
  EXPECT_FALSE(sweeps.take());
  sweeps.put({.volume_index = 7});
  EXPECT_EQ(sweeps.take()->volume_index, 7U);
}

}  // namespace
}  // namespace fanlight
