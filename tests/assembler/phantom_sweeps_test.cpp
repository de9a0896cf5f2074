// SPDX-License-Identifier: Apache-2.0
// The simulated probe with all its faults, read by the acquisition thread.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

struct Played {
  std::uint64_t volumes = 0;
  std::uint64_t backward = 0;
  std::uint32_t fewest_frames = ~0U;
  std::uint32_t most_frames = 0;
  std::uint64_t interpolated = 0;
};

Played play(const std::string& options, AcquisitionCounters& counters) {
  const auto config =
      parse_phantom(options, {.columns = 16, .rows = 16, .pace = PhantomSource::Pace::kUnpaced});
  EXPECT_TRUE(config) << config.error().message;
  const auto source = PhantomSource::create(*config);
  Doorbell reader;
  Doorbell writer;
  VolumeRing ring({.geometry = (*source)->description().geometry,
                   .frame_capacity = (*source)->description().frames_per_volume,
                   .policy = RingPolicy::kProcessAll},
                  {.reader_bell = reader, .writer_bell = writer});
  const AcquisitionThread thread(
      {.source = **source, .ring = ring, .writer_bell = writer, .counters = counters, .ended_bell = reader});
  Played played;
  for (bool ended = false; !ended;) {
    reader.wait(-1);
    ended = thread.state() != AcquisitionThread::State::kRunning;
    while (const auto volume = ring.take()) {
      ++played.volumes;
      if (volume->stamp().direction == SweepDirection::kBackward) ++played.backward;
      played.fewest_frames = std::min(played.fewest_frames, volume->stamp().frames);
      played.most_frames = std::max(played.most_frames, volume->stamp().frames);
      if (volume->stamp().frames_missing > 0) ++played.interpolated;
      const auto angles = volume->angles_rad();
      EXPECT_TRUE(std::ranges::is_sorted(volume->by_angle(), {}, [&](std::uint32_t i) { return angles[i]; }));
    }
  }
  EXPECT_EQ(thread.state(), AcquisitionThread::State::kEnded);
  EXPECT_EQ(counters.frames_received.value(), sum_of_fates(counters));
  EXPECT_EQ(counters.frames_pending.value(), 0U);
  return played;
}

TEST(PhantomSweeps, ByIndexWithJitter) {
  AcquisitionCounters counters;
  const Played played = play("jitter=1,volumes=40", counters);
  EXPECT_EQ(played.volumes, 40U);
  EXPECT_EQ(played.fewest_frames, 35U);
  EXPECT_EQ(counters.frames_assembled.value(), 40U * 35);
}

TEST(PhantomSweeps, ByIndexWithLateAndEarlyTurning) {
  AcquisitionCounters counters;
  const Played played = play("turning=4,volumes=40", counters);
  EXPECT_EQ(played.volumes, 40U);
  EXPECT_LT(played.fewest_frames, 35U);
  EXPECT_GT(played.most_frames, 35U);
  EXPECT_EQ(counters.frames_missing.value(), 0U);
  EXPECT_EQ(counters.volumes_interpolated.value(), 0U);
  EXPECT_EQ(counters.frames_over_capacity.value(), 0U);
}

TEST(PhantomSweeps, ByTheAngleAlone) {
  AcquisitionCounters counters;
  const Played played = play("index=off,turning=4,jitter=0.8,lag=1,volumes=40", counters);
  EXPECT_EQ(played.volumes, 40U);
  EXPECT_EQ(played.backward, 20U);
  EXPECT_GE(played.fewest_frames, 35U - 8 - 2);
  EXPECT_LE(played.most_frames, 35U + 8 + 2);
  EXPECT_EQ(counters.frames_assembled.value(), counters.frames_received.value());
  EXPECT_EQ(counters.frames_missing.value(), 0U);
}

TEST(PhantomSweeps, WithLostFrames) {
  for (const std::string options : {"lost=4,volumes=100", "lost=4,volumes=100,index=off"}) {
    AcquisitionCounters counters;
    const Played played = play(options, counters);
    EXPECT_NEAR(static_cast<double>(counters.frames_missing.value()), 0.04 * 3500, 40) << options;
    EXPECT_NEAR(static_cast<double>(counters.frames_missing.value() + counters.frames_received.value()), 3500,
                3);
    EXPECT_GT(played.interpolated, 50U);
    EXPECT_EQ(played.interpolated, counters.volumes_interpolated.value());
    EXPECT_EQ(played.volumes + counters.volumes_incomplete.value(), 100U);
  }
}

TEST(PhantomSweeps, WithHalfOfTheFramesLostNothingIsShown) {
  AcquisitionCounters counters;
  EXPECT_EQ(play("lost=50,volumes=20", counters).volumes, 0U);
  EXPECT_EQ(counters.volumes_incomplete.value(), 20U);
  EXPECT_EQ(counters.frames_in_incomplete_volumes.value(), counters.frames_received.value());
}

}  // namespace
}  // namespace fanlight
