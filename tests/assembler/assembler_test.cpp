#include "acquisition/assembler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <thread>

#include "proto/fan_geometry.hpp"

namespace fanlight {
namespace {

constexpr std::uint32_t kCapacity = 5;

class AssemblerTest : public testing::Test {
 protected:
  static VolumeRing::Config ring_config(RingPolicy policy) {
    VolumeRing::Config config;
    config.geometry.columns = 4;
    config.geometry.rows = 3;
    config.geometry.pixel_width_mm = 1;
    config.geometry.pixel_height_mm = 1;
    config.geometry.motor_radius_mm = 30;
    config.frame_capacity = kCapacity;
    config.policy = policy;
    return config;
  }

  explicit AssemblerTest(RingPolicy policy = RingPolicy::kNewestWins)
      : ring_(ring_config(policy), {.reader_bell = reader_bell_, .writer_bell = writer_bell_}),
        assembler_({.ring = ring_, .writer_bell = writer_bell_, .counters = counters_}) {}

  /// The next frame of a source that sweeps to and fro.
  FrameStamp frame(std::uint64_t volume_index, std::uint32_t frame_index, std::uint32_t frames_in_sweep) {
    const bool backward = volume_index % 2 == 1;
    const double angle_deg = 2.0 * frame_index;
    return {.sequence = sequence_++,
            .volume_index = volume_index,
            .frame_index = frame_index,
            .frames_in_sweep = frames_in_sweep,
            .direction = backward ? SweepDirection::kBackward : SweepDirection::kForward,
            .angle_rad = radians(backward ? 20 - angle_deg : angle_deg),
            .capture_time_ns = static_cast<std::int64_t>(1000 * sequence_)};
  }

  bool add(const FrameStamp& stamp) {
    const auto pixels = assembler_.place(stamp, stop_.get_token());
    if (pixels.empty()) return false;
    std::ranges::fill(pixels, static_cast<std::uint8_t>(stamp.sequence));
    assembler_.commit();
    return true;
  }

  void add_sweep(std::uint64_t volume_index, std::uint32_t frames, std::uint32_t announced) {
    for (std::uint32_t i = 0; i < frames; ++i) add(frame(volume_index, i, announced));
  }

  std::uint64_t published() const { return ring_.counters().volumes_published.value(); }

  void expect_identity() const {
    EXPECT_EQ(counters_.frames_received.value(),
              counters_.frames_assembled.value() + counters_.frames_invalid.value() +
                  counters_.frames_over_capacity.value() + counters_.frames_in_short_volumes.value() +
                  counters_.frames_abandoned.value() + assembler_.frames_pending());
  }

  Doorbell reader_bell_;
  Doorbell writer_bell_;
  AcquisitionCounters counters_;
  std::stop_source stop_;
  VolumeRing ring_;
  Assembler assembler_;
  std::uint64_t sequence_ = 0;
};

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

TEST_F(AssemblerTest, PublishesTheRestAtTheEndOfTheSource) {
  add_sweep(0, 3, 5);
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
  EXPECT_EQ(published(), 1U);
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
  expect_identity();
}

TEST_F(AssemblerTest, AFramePlacedAndNeverCommittedIsMissing) {
  add_sweep(0, 2, 4);
  EXPECT_FALSE(assembler_.place(frame(0, 2, 4), stop_.get_token()).empty());
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

TEST_F(AssemblerTest, TheIdentityHoldsAfterEveryFrameOfADisorderlySource) {
  std::mt19937 random(5);
  const auto chance = [&random](unsigned percent) { return random() % 100 < percent; };
  std::uint64_t volume_index = 0;
  std::uint32_t index = 0;
  for (int i = 0; i < 20'000; ++i) {
    FrameStamp stamp = frame(volume_index, index++, chance(50) ? 4 : 0);
    if (chance(5)) sequence_ += random() % 3;
    if (chance(10)) stamp.angle_rad = std::nan("");
    if (chance(10)) stamp.angle_rad = 0.1;
    if (chance(5)) {
      assembler_.reject(stamp, FrameFault::kInvalid);
    } else if (chance(2)) {
      (void)assembler_.place(stamp, stop_.get_token());
    } else {
      add(stamp);
    }
    if (chance(1)) assembler_.abandon();
    if (chance(20)) {
      ++volume_index;
      index = 0;
    }
    expect_identity();
    ASSERT_FALSE(HasFailure()) << "at frame " << i;
  }
  assembler_.end_of_source();
  EXPECT_EQ(assembler_.frames_pending(), 0U);
  expect_identity();
  const AcquisitionCounters& counters = counters_;
  for (const Counter* counter :
       {&counters.frames_assembled, &counters.frames_invalid, &counters.frames_over_capacity,
        &counters.frames_in_short_volumes, &counters.frames_abandoned, &counters.frames_missing}) {
    EXPECT_GT(counter->value(), 0U) << "a case that this test did not reach";
  }
}

class AssemblerToAFileTest : public AssemblerTest {
 protected:
  AssemblerToAFileTest() : AssemblerTest(RingPolicy::kProcessAll) {
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
  EXPECT_TRUE(assembler_.place(frame(90, 0, 3), stop_.get_token()).empty());
  EXPECT_EQ(counters_.frames_received.value(), received);
  expect_identity();
}

}  // namespace
}  // namespace fanlight
