// From the emulated probe to the ring: every fault under its own name, and the sum right all the while.
#include "tests/usb/live_house.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace fanlight::test {
namespace {

ProbeModel::Config small() {
  return {.frame_rate_hz = 200, .frames_per_volume = 20, .columns = 64, .rows = 64, .room_frames = 1000};
}

/// Looks at the sum without a pause, in a thread of its own.
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

TEST(LiveHouse, EveryFaultIsCountedUnderItsName) {
  // Each of the first sweeps has one fault; number 8 lacks five frames, which do not lie side by side: the
  // emulator asks its script before a frame that it sends, and may pass over one that follows a drop.
  LiveHouse house(
      {.model = small(),
       .faults = "frame 5 drop; frame 25 repeat; frame 46 swap; frame 65 damage; frame 85 cut; frame 105 "
                 "invalid; frame 125 misfit; frame 130 noise 500; frame 145 damage-header;"
                 "frame 165 drop; frame 167 drop; frame 169 drop; frame 171 drop; frame 173 drop; frame 205 "
                 "restart",
       .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  const AcquisitionCounters& frames = house.frames();
  {
    const Auditor auditor(frames);
    house.start();
    ASSERT_TRUE(wait_until(
        [&] { return frames.sequence_restarts.value() == 1 && frames.frames_assembled.value() > 220; }));
  }
  house.stop();
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
  EXPECT_EQ(house.counters().bytes_skipped.value(), 500 + probe::kFrameHeaderBytes + 64 * 64);
  EXPECT_TRUE(frames.sum_holds());
}

TEST(LiveHouse, TheSumHoldsWhileTheCableIsPulled) {
  LiveHouse house({.model = small(), .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  const Auditor auditor(house.frames());
  house.start();
  for (std::uint64_t round = 1; round <= 5; ++round) {
    const std::uint64_t volumes = house.ring().counters().volumes_published.value();
    ASSERT_TRUE(wait_until([&] { return house.ring().counters().volumes_published.value() > volumes; }));
    ASSERT_TRUE(wait_until([&] { return house.frames().frames_pending.value() > 2; }));
    house.probe().unplug();
    ASSERT_TRUE(wait_until([&] { return house.counters().probes_lost.value() == round; }));
    house.probe().plug();
  }
  EXPECT_GT(house.frames().frames_abandoned.value() + house.frames().frames_cut.value(), 0U);
}

TEST(LiveHouse, AProbeThatDoesNotCountVolumesIsCutWhereItTurns) {
  auto model = small();
  model.counts_volumes = false;
  LiveHouse house({.model = model, .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  house.start();
  ASSERT_TRUE(wait_until([&] { return house.ring().counters().volumes_published.value() >= 4; }));
  const auto volume = house.ring().take();
  ASSERT_TRUE(volume);
  EXPECT_NEAR(volume->stamp().frames, 20, 2);
  const auto angles = volume->angles_rad();
  EXPECT_NEAR(degrees(std::abs(angles.back() - angles.front())), 70, 8);
  house.stop();
  EXPECT_TRUE(house.frames().sum_holds());
}

// Who renders every volume makes the probe wait. That is no silence of the probe's, and what it drops
// meanwhile is counted.
TEST(LiveHouse, WaitingForRoomIsNoSilence) {
  auto model = small();
  model.room_frames = 4;
  LiveHouse house({.model = model,
                   .reads = {.transfers = 16, .transfer_bytes = 16 << 10},
                   .policy = RingPolicy::kProcessAll});
  house.start();
  const auto published = [&] { return house.ring().counters().volumes_published.value(); };
  ASSERT_TRUE(wait_until([&] { return published() == 4; })) << "as many as have room";
  std::this_thread::sleep_for(std::chrono::milliseconds(2000));  // longer than any silence is borne
  for (std::uint64_t taken = 0; taken < 8;) {
    if (house.ring().take()) ++taken;
    std::this_thread::yield();
  }
  EXPECT_EQ(house.counters().streams_restarted.value(), 0U);
  EXPECT_GT(house.frames().frames_missing.value(), 200U) << "two seconds of frames";
  house.stop();
  EXPECT_TRUE(house.frames().sum_holds());
}

}  // namespace
}  // namespace fanlight::test
