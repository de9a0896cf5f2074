// SPDX-License-Identifier: Apache-2.0
#include "server/state/loop_watch.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "proto/exchange/doorbell.hpp"
#include "server/state/picture_times.hpp"

namespace fanlight::test {
namespace {

constexpr std::int64_t kS = 1'000'000'000;

TEST(LoopWatchTest, TellsOfTheLoopWhosePulseHasStopped) {
  Pulse moving;
  Pulse stopped;
  const auto always = [] { return true; };
  LoopWatch watch({{"moving", &moving, always}, {"stopped", &stopped, always}}, 3 * kS, 0);
  const auto beat = [](Pulse& pulse) {
    const Pulse::OfThisThread mine(pulse);
    Pulse::beat();
  };
  for (std::int64_t second = 1; second <= 3; ++second) {
    beat(moving);
    EXPECT_EQ(watch.still(second * kS), nullptr);
  }
  beat(moving);
  const LoopWatch::Loop* const still = watch.still(4 * kS);
  ASSERT_NE(still, nullptr);
  EXPECT_EQ(still->name, "stopped");
  beat(stopped);
  EXPECT_EQ(watch.still(5 * kS), nullptr) << "it moves again";
}

TEST(LoopWatchTest, ALoopThatHasEndedNeedNotMove) {
  Pulse pulse;
  bool runs = true;
  LoopWatch watch({{"acquisition", &pulse, [&] { return runs; }}}, kS, 0);
  EXPECT_NE(watch.still(2 * kS), nullptr);
  runs = false;
  EXPECT_EQ(watch.still(9 * kS), nullptr);
}

TEST(LoopWatchTest, AThreadThatWaitsForItsBellBeats) {
  Pulse pulse;
  Doorbell bell;
  std::jthread thread([&] {
    const Pulse::OfThisThread mine(pulse);
    EXPECT_TRUE(bell.wait(-1));
  });
  for (int i = 0; i < 100 && pulse.beats() == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_GT(pulse.beats(), 0U) << "a wait without an end beats once a second";
  bell.ring();
}

TEST(PictureTimesTest, CountsEachStageAndEachVolumeOnce) {
  PictureTimes times;
  PictureStamp stamp;
  stamp.volume.volume_id = 1;
  stamp.volume.last_capture_time_ns = 1 * kS;
  stamp.finished_time_ns = 3 * kS;
  stamp.stage_ms[0] = 4;
  times.shown(stamp);
  stamp.stage_ms[0] = 0;  // a moved light casts no ray
  stamp.finished_time_ns = 9 * kS;
  times.shown(stamp);
  EXPECT_EQ(times.stages()[0].count(), 1U);
  EXPECT_EQ(times.ages().count(), 1U) << "the same volume again";
  stamp.volume.volume_id = 2;
  times.shown(stamp);
  stamp.volume.volume_id = 1;
  times.shown(stamp);
  EXPECT_EQ(times.ages().count(), 2U) << "a frozen display looks at an older volume";
  EXPECT_DOUBLE_EQ(times.ages().sum_s(), 2 + 8);
  const auto counts = times.stages()[0].cumulative();
  ASSERT_EQ(counts.size(), TimeHistogram::kBoundsS.size() + 1);
  EXPECT_EQ(counts[2], 0U) << "not at most 2.5 ms";
  EXPECT_EQ(counts[3], 1U) << "at most 5 ms";
  EXPECT_EQ(counts.back(), 1U);
}

TEST(TimeHistogramTest, ABoundBelongsToItsBucket) {
  TimeHistogram times;
  times.add(0.5);
  times.add(1000);
  EXPECT_EQ(times.cumulative()[9], 1U);
  EXPECT_EQ(times.cumulative()[14], 1U) << "beyond the last bound";
  EXPECT_EQ(times.cumulative()[15], 2U);
}

}  // namespace
}  // namespace fanlight::test
