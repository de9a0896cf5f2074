// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <thread>
#include <vector>

#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

constexpr std::uint32_t kCapacity = 5;

TEST_F(AssemblerTest, PublishesWithTheLastAnnouncedFrame) {
  add_sweep(7, 3, 4);
  EXPECT_EQ(published(), 0U);
  EXPECT_EQ(assembler_.frames_pending(), 3U);
  add(frame(7, 3, 4));
  EXPECT_EQ(published(), 1U);
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->stamp().source_volume_index, 7U);
  EXPECT_EQ(volume->stamp().frames, 4U);
  EXPECT_EQ(volume->stamp().first_frame_sequence, 0U);
  EXPECT_EQ(volume->stamp().last_frame_sequence, 3U);
  EXPECT_EQ(volume->stamp().first_capture_time_ns, 1000);
  EXPECT_EQ(volume->stamp().last_capture_time_ns, 4000);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(volume->frame_pixels(i)[0], i);
  expect_identity();
}

TEST_F(AssemblerTest, PublishesWhenAnotherSweepBegins) {
  add_sweep(0, 3, 0);
  add_sweep(1, 1, 0);
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(assembler_.frames_pending(), 1U);
  expect_identity();
}

TEST_F(AssemblerTest, DropsASweepThatTheEndOfTheSourceCutsOff) {
  add_sweep(0, 10, 10);
  add_sweep(1, 5, 10);
  assembler_.end_of_source();
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(counters_.frames_abandoned.value(), 5U);
  expect_identity();
}

TEST_F(AssemblerTest, PublishesTheRestAtTheEndOfTheSource) {
  add_sweep(0, 3, 0);
  assembler_.end_of_source();
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames, 3U);
  assembler_.end_of_source();
  EXPECT_EQ(published(), 1U);
  expect_identity();
}

TEST_F(AssemblerTest, ABackwardSweepReadsInAscendingAngles) {
  add_sweep(1, 4, 4);
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->stamp().direction, SweepDirection::kBackward);
  const auto order = volume->by_angle();
  EXPECT_TRUE(std::ranges::equal(order, std::vector<std::uint32_t>{3, 2, 1, 0}));
}

TEST_F(AssemblerTest, AHandThatWaversIsPutInOrder) {
  for (const double angle_deg : {1.0, 2.0, 2.0, 1.5, 3.0}) {
    FrameStamp stamp = frame(0, static_cast<std::uint32_t>(sequence_), kCapacity);
    stamp.angle_rad = radians(angle_deg);
    EXPECT_TRUE(add(stamp));
  }
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_TRUE(std::ranges::equal(volume->by_angle(), std::vector<std::uint32_t>{0, 3, 1, 2, 4}));
}

TEST_F(AssemblerTest, DropsAndCountsASweepThatDoesNotMove) {
  for (std::uint32_t i = 0; i < 4; ++i) {
    FrameStamp stamp = frame(0, i, 4);
    stamp.angle_rad = radians(5 + 0.002 * i);
    EXPECT_TRUE(add(stamp));
  }
  add_sweep(1, 1, 1);
  EXPECT_EQ(published(), 0U);
  EXPECT_EQ(counters_.volumes_short.value(), 2U);
  EXPECT_EQ(counters_.frames_in_short_volumes.value(), 5U);
  expect_identity();
}

TEST_F(AssemblerTest, CountsFramesWithAnUnusableAngleAndStillEndsTheSweep) {
  const double inf = std::numeric_limits<double>::infinity();
  add_sweep(0, 2, 5);
  std::uint32_t index = 2;
  for (const double angle_rad : {std::nan(""), inf, -kPi / 2}) {
    FrameStamp stamp = frame(0, index++, 5);
    stamp.angle_rad = angle_rad;
    EXPECT_FALSE(add(stamp));
  }
  EXPECT_EQ(counters_.frames_invalid.value(), 3U);
  EXPECT_EQ(counters_.frames_received.value(), 5U);
  EXPECT_EQ(counters_.volumes_incomplete.value(), 1U) << "three of five are missing from its volume";
  EXPECT_EQ(counters_.frames_in_incomplete_volumes.value(), 2U);
  expect_identity();
}

TEST_F(AssemblerTest, CountsEachFaultUnderItsName) {
  add(frame(0, 0, 0));
  assembler_.reject(frame(0, 1, 0), FrameFault::kDamaged);
  assembler_.reject(frame(0, 2, 0), FrameFault::kCut);
  assembler_.reject(frame(0, 3, 0), FrameFault::kMisfit);
  const FrameStamp placed = frame(0, 4, 0);
  EXPECT_FALSE(assembler_.place(placed, geometry_, stop_.get_token()).empty());
  assembler_.reject(placed, FrameFault::kInvalid);
  EXPECT_EQ(counters_.frames_damaged.value(), 1U);
  EXPECT_EQ(counters_.frames_cut.value(), 1U);
  EXPECT_EQ(counters_.frames_misfit.value(), 1U);
  EXPECT_EQ(counters_.frames_invalid.value(), 1U);
  EXPECT_EQ(counters_.frames_received.value(), 5U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U) << "they came, though without pixels";
  expect_identity();
}

TEST_F(AssemblerTest, ARejectedLastFrameEndsItsSweep) {
  add_sweep(0, 3, 4);
  assembler_.reject(frame(0, 3, 4), FrameFault::kInvalid);
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(counters_.frames_invalid.value(), 1U);
  expect_identity();
}

TEST_F(AssemblerTest, ARejectedFirstFrameEndsTheSweepBefore) {
  add_sweep(0, 3, 0);
  assembler_.reject(frame(1, 0, 0), FrameFault::kInvalid);
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(assembler_.frames_pending(), 0U);
  expect_identity();
}

TEST_F(AssemblerTest, CountsFramesBeyondTheCapacity) {
  add_sweep(0, kCapacity + 3, kCapacity + 3);
  EXPECT_EQ(counters_.frames_over_capacity.value(), 3U);
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames, kCapacity);
  expect_identity();
}

TEST_F(AssemblerTest, CountsFramesBeyondWhatTheSweepAnnounced) {
  add_sweep(0, 5, 3);
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(counters_.frames_over_capacity.value(), 2U);
  add_sweep(1, 3, 3);
  EXPECT_EQ(published(), 2U);
  expect_identity();
}

TEST_F(AssemblerTest, CountsGapsOfTheSequenceAsMissing) {
  sequence_ = 2;  // the first two were lost
  add_sweep(0, 2, 4);
  ++sequence_;
  add(frame(0, 3, 4));
  EXPECT_EQ(counters_.frames_missing.value(), 3U);
  EXPECT_EQ(counters_.frames_received.value(), 3U);
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames_missing, 1U) << "the first two were of no sweep";
  expect_identity();
}

TEST_F(AssemblerTest, AFramePlacedAndNeverCommittedIsMissing) {
  add_sweep(0, 2, 4);
  EXPECT_FALSE(assembler_.place(frame(0, 2, 4), geometry_, stop_.get_token()).empty());
  add(frame(0, 3, 4));
  EXPECT_EQ(counters_.frames_missing.value(), 1U);
  EXPECT_EQ(ring_.take()->stamp().frames, 3U);
  expect_identity();
}

TEST_F(AssemblerTest, AbandonsAndCountsTheSweepUnderWay) {
  add_sweep(0, 3, 4);
  assembler_.abandon();
  EXPECT_EQ(counters_.frames_abandoned.value(), 3U);
  EXPECT_EQ(assembler_.frames_pending(), 0U);
  assembler_.end_of_source();
  EXPECT_EQ(published(), 0U);
  expect_identity();
}

class AssemblerToAFileTest : public AssemblerTest {
 protected:
  AssemblerToAFileTest() : AssemblerTest({.policy = RingPolicy::kProcessAll}) {
    for (std::uint64_t volume = 0; volume < VolumeRing::Config{}.slots; ++volume) add_sweep(volume, 3, 3);
  }
};

TEST_F(AssemblerToAFileTest, WaitsForRoomAndLosesNothing) {
  std::jthread reader([this] {
    for (std::uint64_t volume = 0; volume < 50;) {
      reader_bell_.wait(-1);
      while (const auto lease = ring_.take()) {
        EXPECT_EQ(lease->stamp().source_volume_index, volume);
        ++volume;
      }
    }
  });
  for (std::uint64_t volume = VolumeRing::Config{}.slots; volume < 50; ++volume) add_sweep(volume, 3, 3);
  reader.join();
  EXPECT_EQ(counters_.frames_assembled.value(), 150U);
  expect_identity();
}

TEST_F(AssemblerToAFileTest, AStopEndsTheWaitAndCountsNothing) {
  const std::uint64_t received = counters_.frames_received.value();
  std::jthread stopper([this] { stop_.request_stop(); });
  EXPECT_TRUE(assembler_.place(frame(90, 0, 3), geometry_, stop_.get_token()).empty());
  EXPECT_EQ(counters_.frames_received.value(), received);
  expect_identity();
}

}  // namespace
}  // namespace fanlight
