// SPDX-License-Identifier: Apache-2.0
// From the emulated probe to the ring: every fault raises its own counter, and the sum of the counters always
// holds.
#include "tests/usb/acquisition_fixture.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace fanlight::test {
namespace {

ProbeModel::Config small() {
  return {.frame_rate_hz = 200, .frames_per_volume = 20, .columns = 64, .rows = 64, .room_frames = 1000};
}

/// Checks the sum continuously on a thread of its own.
class Auditor {
 public:
  explicit Auditor(const AcquisitionCounters& frames)
      : thread_([this, &frames](const std::stop_token& stop) {
          while (!stop.stop_requested()) {
            if (!frames.sum_holds()) wrong_ = true;
            ++looks_;
          }
        }) {}
  ~Auditor() {
    thread_.request_stop();
    thread_.join();
    EXPECT_FALSE(wrong_) << "at some moment the sum of the frames was wrong";
    EXPECT_GT(looks_, 0U);
  }

 private:
  std::atomic<bool> wrong_{false};
  std::atomic<std::uint64_t> looks_{0};
  std::jthread thread_;
};

TEST(AcquisitionFixture, EveryFaultIsCountedUnderItsName) {
  // Each of the first sweeps has one fault. Sweep 8 lacks five frames that are not adjacent: the emulator
  // evaluates its script before a frame that it sends, and may pass over one that follows a drop.
  AcquisitionFixture fixture(
      {.model = small(),
       .faults = "frame 5 drop; frame 25 repeat; frame 46 swap; frame 65 damage; frame 85 cut; frame 105 "
                 "invalid; frame 125 misfit; frame 130 noise 500; frame 145 damage-header;"
                 "frame 165 drop; frame 167 drop; frame 169 drop; frame 171 drop; frame 173 drop; frame 205 "
                 "restart",
       .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  const AcquisitionCounters& frames = fixture.frames();
  {
    const Auditor auditor(frames);
    fixture.start();
    ASSERT_TRUE(wait_until(
        [&] { return frames.sequence_restarts.value() == 1 && frames.frames_assembled.value() > 220; }));
  }
  fixture.stop();
  EXPECT_EQ(frames.frames_repeated.value(), 1U);
  EXPECT_EQ(frames.frames_reordered.value(), 1U);
  EXPECT_EQ(frames.frames_damaged.value(), 1U);
  EXPECT_EQ(frames.frames_invalid.value(), 1U);
  EXPECT_EQ(frames.frames_misfit.value(), 1U);
  EXPECT_GE(frames.frames_cut.value(), 1U) << "the one, and perhaps the one under way at the end";
  EXPECT_EQ(frames.frames_missing.value(), 1U + 1 + 5)
      << "dropped, with a damaged header, and five of one sweep";
  EXPECT_EQ(frames.volumes_incomplete.value(), 1U);
  EXPECT_EQ(frames.frames_in_incomplete_volumes.value(), 15U);
  EXPECT_GE(frames.volumes_interpolated.value(), 5U);
  EXPECT_EQ(fixture.counters().bytes_skipped.value(), 500 + probe::kFrameHeaderBytes + 64 * 64);
  EXPECT_TRUE(frames.sum_holds());
}

TEST(AcquisitionFixture, TheSumHoldsWhileTheCableIsPulled) {
  AcquisitionFixture fixture({.model = small(), .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  const Auditor auditor(fixture.frames());
  fixture.start();
  for (std::uint64_t round = 1; round <= 5; ++round) {
    const std::uint64_t volumes = fixture.ring().counters().volumes_published.value();
    ASSERT_TRUE(wait_until([&] { return fixture.ring().counters().volumes_published.value() > volumes; }));
    ASSERT_TRUE(wait_until([&] { return fixture.frames().frames_pending.value() > 2; }));
    fixture.probe().unplug();
    ASSERT_TRUE(wait_until([&] { return fixture.counters().probes_lost.value() == round; }));
    fixture.probe().plug();
  }
  EXPECT_GT(fixture.frames().frames_abandoned.value() + fixture.frames().frames_cut.value(), 0U);
}

TEST(AcquisitionFixture, AProbeThatDoesNotCountVolumesIsCutWhereItTurns) {
  auto model = small();
  model.counts_volumes = false;
  AcquisitionFixture fixture({.model = model, .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  fixture.start();
  ASSERT_TRUE(wait_until([&] { return fixture.ring().counters().volumes_published.value() >= 4; }));
  const auto volume = fixture.ring().take();
  ASSERT_TRUE(volume);
  EXPECT_NEAR(volume->stamp().frames, 20, 2);
  const auto angles = volume->angles_rad();
  EXPECT_NEAR(degrees(std::abs(angles.back() - angles.front())), 70, 8);
  fixture.stop();
  EXPECT_TRUE(fixture.frames().sum_holds());
}

// A reader that processes every volume blocks the source. That is no silence of the probe, and the frames
// that the probe drops meanwhile are counted.
TEST(AcquisitionFixture, WaitingForRoomIsNoSilence) {
  auto model = small();
  model.room_frames = 4;
  AcquisitionFixture fixture({.model = model,
                              .reads = {.transfers = 16, .transfer_bytes = 16 << 10},
                              .policy = RingPolicy::kProcessAll});
  fixture.start();
  const auto published = [&] { return fixture.ring().counters().volumes_published.value(); };
  ASSERT_TRUE(wait_until([&] { return published() == 4; })) << "as many as have room";
  // Longer than SilenceWatch::kSilenceNs. A sleep, because the emulated probe makes no frames while no one
  // reads: there is no condition to wait for. SilenceWatch.ABlockedCallerIsNoSilenceOfTheProbe injects the
  // time.
  std::this_thread::sleep_for(std::chrono::milliseconds(2000));
  for (std::uint64_t taken = 0; taken < 8;) {
    if (fixture.ring().take()) ++taken;
    std::this_thread::yield();
  }
  EXPECT_EQ(fixture.counters().streams_restarted.value(), 0U);
  EXPECT_GT(fixture.frames().frames_missing.value(), 200U) << "two seconds of frames";
  fixture.stop();
  EXPECT_TRUE(fixture.frames().sum_holds());
}

}  // namespace
}  // namespace fanlight::test
