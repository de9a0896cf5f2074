// SPDX-License-Identifier: Apache-2.0
#include "acquisition/acquisition_thread.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "acquisition/phantom/phantom_source.hpp"
#include "acquisition/source/pacer.hpp"

namespace fanlight {
namespace {

/// Gives `frames` frames of one sweep, then ends, fails, or waits for a frame that never arrives.
class ScriptedSource final : public FrameSource {
 public:
  enum class Then : std::uint8_t { kEnd, kFail, kWait };

  ScriptedSource(std::uint32_t frames, Then then) : frames_(frames), then_(then) {
    description_.geometry.columns = 4;
    description_.geometry.rows = 4;
    description_.geometry.pixel_width_mm = 1;
    description_.geometry.pixel_height_mm = 1;
    description_.geometry.motor_radius_mm = 30;
    description_.frames_per_volume = frames;
  }

  const SourceDescription& description() const override { return description_; }

  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override {
    if (next_ < frames_) {
      const std::uint32_t index = next_++;
      FrameStamp stamp;
      stamp.sequence = index;
      stamp.frame_index = index;
      stamp.angle_rad = 0.01 * index;
      return std::optional(stamp);
    }
    if (then_ == Then::kFail) return Error{ErrorCode::kUnavailable, "the probe was unplugged"};
    constexpr std::int64_t kNever = std::int64_t{1} << 62;
    if (then_ == Then::kWait) pacer_.wait_until(kNever, stop);
    return std::optional<FrameStamp>{};
  }

  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token /*stop*/) override {
    std::ranges::fill(pixels, std::uint8_t{1});
    return FrameFault::kNone;
  }
  FrameFault known_fault() const override { return next_ == 2 ? FrameFault::kInvalid : FrameFault::kNone; }

 private:
  std::uint32_t frames_;
  Then then_;
  std::uint32_t next_ = 0;
  Pacer pacer_;
  SourceDescription description_;
};

struct Acquisition {
  explicit Acquisition(FrameSource& source, RingPolicy policy = RingPolicy::kNewestWins)
      : ring({.geometry = source.description().geometry,
              .frame_capacity = source.description().frames_per_volume,
              .policy = policy},
             {.reader_bell = reader_bell, .writer_bell = writer_bell}),
        queue({.largest_frame_bytes = source.description().geometry.frame_bytes()},
              {.reader_bell = reader_bell}),
        thread({.source = source,
                .ring = ring,
                .writer_bell = writer_bell,
                .counters = counters,
                .ended_bell = ended_bell,
                .frame_queue = &queue}) {}

  Doorbell reader_bell;
  Doorbell writer_bell;
  Doorbell ended_bell;
  AcquisitionCounters counters;
  VolumeRing ring;
  FrameQueue queue;
  AcquisitionThread thread;
};

TEST(AcquisitionThread, EndsWithItsSourceAndPublishesTheLastSweep) {
  ScriptedSource source(6, ScriptedSource::Then::kEnd);
  Acquisition acquisition(source);
  EXPECT_TRUE(acquisition.ended_bell.wait(-1));
  EXPECT_EQ(acquisition.thread.state(), AcquisitionThread::State::kEnded);
  const auto volume = acquisition.ring.take();
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->stamp().frames, 5U);
  EXPECT_EQ(acquisition.counters.frames_invalid.value(), 1U);
  EXPECT_EQ(acquisition.counters.frames_received.value(), 6U);
}

TEST(AcquisitionThread, FeedsTheFramesOfItsVolume) {
  ScriptedSource source(6, ScriptedSource::Then::kEnd);
  Acquisition acquisition(source);
  EXPECT_TRUE(acquisition.ended_bell.wait(-1));
  const auto volume = acquisition.ring.take();
  ASSERT_TRUE(volume);
  ASSERT_EQ(volume->commit_numbers().size(), 5U);
  for (const std::uint64_t commit_number : volume->commit_numbers()) {
    const QueuedFrame* const queued = acquisition.queue.front();
    ASSERT_NE(queued, nullptr);
    EXPECT_EQ(queued->stamp.commit_number, commit_number);
    EXPECT_EQ(queued->geometry, source.description().geometry);
    EXPECT_EQ(std::ranges::count(queued->pixels, 1), 16);
    acquisition.queue.pop();
  }
  EXPECT_EQ(acquisition.queue.front(), nullptr);
}

TEST(AcquisitionThread, NeverWaitsForAFullFeed) {
  ScriptedSource source(20, ScriptedSource::Then::kEnd);
  Acquisition acquisition(source);
  EXPECT_TRUE(acquisition.ended_bell.wait(-1));
  const auto volume = acquisition.ring.take();
  ASSERT_TRUE(volume);
  EXPECT_EQ(volume->stamp().frames, 19U);
  EXPECT_EQ(acquisition.queue.counters().frames_fed.value(), FrameQueue::Config{}.slots);
  EXPECT_EQ(acquisition.queue.counters().frames_not_fed.value(), 19U - FrameQueue::Config{}.slots);
}

TEST(AcquisitionThread, KeepsTheErrorOfItsSource) {
  ScriptedSource source(6, ScriptedSource::Then::kFail);
  Acquisition acquisition(source);
  EXPECT_TRUE(acquisition.ended_bell.wait(-1));
  ASSERT_EQ(acquisition.thread.state(), AcquisitionThread::State::kFailed);
  EXPECT_EQ(acquisition.thread.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(acquisition.thread.error().message, "the probe was unplugged");
  EXPECT_FALSE(acquisition.ring.take()) << "the sweep that it failed in is not whole";
  EXPECT_GT(acquisition.counters.frames_abandoned.value(), 0U);
}

// These tests pass if they end: without the stop, the waits would last for years.
TEST(AcquisitionThread, AStopEndsTheWaitForAFrame) {
  ScriptedSource source(6, ScriptedSource::Then::kWait);
  Acquisition acquisition(source);
  EXPECT_EQ(acquisition.thread.state(), AcquisitionThread::State::kRunning);
  acquisition.thread.request_stop();
  EXPECT_TRUE(acquisition.ended_bell.wait(-1));
  EXPECT_EQ(acquisition.thread.state(), AcquisitionThread::State::kStopped);
  EXPECT_EQ(acquisition.counters.frames_received.value(),
            acquisition.counters.frames_abandoned.value() + acquisition.counters.frames_invalid.value());
}

TEST(AcquisitionThread, DestructionEndsTheWaitForAFrame) {
  ScriptedSource source(0, ScriptedSource::Then::kWait);
  const Acquisition acquisition(source);
}

TEST(AcquisitionThread, AStopEndsTheWaitForRoom) {
  auto source = PhantomSource::create({.columns = 16, .rows = 16, .pace = PhantomSource::Pace::kUnpaced});
  ASSERT_TRUE(source);
  Acquisition acquisition(**source, RingPolicy::kProcessAll);
  while (acquisition.ring.counters().volumes_published.value() < VolumeRing::Config{}.slots) {
    acquisition.reader_bell.wait(-1);
  }
  acquisition.thread.request_stop();
  EXPECT_TRUE(acquisition.ended_bell.wait(-1));
  EXPECT_EQ(acquisition.thread.state(), AcquisitionThread::State::kStopped);
}

TEST(AcquisitionThread, BringsThePhantomsVolumesInBothDirections) {
  auto source = PhantomSource::create({.columns = 32, .rows = 32, .pace = PhantomSource::Pace::kUnpaced});
  ASSERT_TRUE(source);
  Acquisition acquisition(**source, RingPolicy::kProcessAll);
  for (std::uint64_t volumes = 0; volumes < 20;) {
    acquisition.reader_bell.wait(-1);
    while (const auto volume = acquisition.ring.take()) {
      EXPECT_EQ(volume->stamp().source_volume_index, volumes);
      EXPECT_EQ(volume->stamp().frames, 35U);
      EXPECT_EQ(volume->stamp().direction,
                volumes % 2 == 0 ? SweepDirection::kForward : SweepDirection::kBackward);
      const auto angles = volume->angles_rad();
      EXPECT_TRUE(std::ranges::is_sorted(volume->by_angle(), {}, [&](std::uint32_t i) { return angles[i]; }));
      ++volumes;
    }
  }
  EXPECT_EQ(acquisition.counters.frames_missing.value(), 0U);
}

}  // namespace
}  // namespace fanlight
