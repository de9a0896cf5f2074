// SPDX-License-Identifier: Apache-2.0
// Whether the picture is live, and the cause where it is not. Time and counters are set by the test.
#include "server/state/picture_liveness.hpp"

#include <gtest/gtest.h>

#include "tests/support/milliseconds.hpp"

namespace fanlight::test {
namespace {

using Liveness = PictureLiveness::State;
using Cause = PictureLiveness::Cause;

/// A source of one sweep in `sweep_ms`, 20 frames each, and a renderer that takes `render_ms` for a volume.
class LivenessTest : public testing::Test {
 protected:
  /// One sweep passes; its volume is published where it is complete, and shown where there is a renderer.
  void sweep(bool complete = true, bool rendered = true) {
    for (int frame = 0; frame < 20; ++frame) {
      now_ns_ += sweep_ms_ * kMs / 20;
      acquisition_.frames_received.add();
      update();
    }
    if (!complete) {
      acquisition_.volumes_incomplete.add();
    } else {
      ring_.volumes_published.add();
      if (rendered) show(now_ns_);
    }
    update();
  }

  /// A picture of a sweep that ended at `captured_ns` is shown now.
  void show(std::int64_t captured_ns) {
    PictureStamp stamp;
    const auto newer = static_cast<std::uint64_t>((now_ns_ - captured_ns) / (sweep_ms_ * kMs));
    stamp.volume = {.volume_id = ring_.volumes_published.value() - newer,
                    .frames = 20,
                    .first_capture_time_ns = captured_ns - sweep_ms_ * kMs,
                    .last_capture_time_ns = captured_ns};
    stamp.finished_time_ns = now_ns_;
    liveness_.shown(stamp, now_ns_);
  }

  /// Time passes without a frame.
  void pass(std::int64_t ms) {
    for (; ms > 0; ms -= 250) {
      now_ns_ += std::min<std::int64_t>(ms, 250) * kMs;
      update();
    }
  }

  bool update() { return liveness_.update(source_, now_ns_); }
  Liveness state() const { return liveness_.report().state; }
  Cause cause() const { return liveness_.report().cause; }
  const std::string& sentence() const { return liveness_.report().sentence; }

  /// Sweeps until the picture is not live, and returns how long that took.
  std::int64_t ms_until_not_live(bool complete, bool rendered) {
    const std::int64_t from_ns = now_ns_;
    while (state() == Liveness::kLive && now_ns_ < from_ns + 60'000 * kMs) sweep(complete, rendered);
    return (now_ns_ - from_ns) / kMs;
  }

  std::int64_t now_ns_ = 1'000'000 * kMs;
  std::int64_t sweep_ms_ = 200;
  PictureLiveness::Source source_;
  AcquisitionCounters acquisition_;
  RingCounters ring_;
  QueueCounters queue_;
  RenderCounters render_;
  ProbeCounters probe_;
  IgtlCounters igtl_;
  PipelineCounters pipeline_{acquisition_, ring_, queue_, render_, probe_, igtl_};
  PictureLiveness liveness_{pipeline_, now_ns_};
};

TEST_F(LivenessTest, WaitsForTheFirstPictureAndIsLiveThen) {
  EXPECT_EQ(state(), Liveness::kWaiting);
  sweep(true, false);
  EXPECT_EQ(state(), Liveness::kWaiting);
  EXPECT_EQ(cause(), Cause::kNone);
  sweep();
  EXPECT_EQ(state(), Liveness::kLive);
  EXPECT_NEAR(liveness_.report().age_s, 0, 0.01);
}

TEST_F(LivenessTest, HasTheRateOfItsLastPictures) {
  for (int volume = 0; volume < 20; ++volume) sweep();
  EXPECT_NEAR(liveness_.report().pictures_per_second, 5, 0.01);
}

TEST_F(LivenessTest, ARestIsNoFaultUnlessTheSourceHasOne) {
  sweep();
  source_.resting = true;
  for (int sweeps = 0; sweeps < 50; ++sweeps) sweep(true, false);
  EXPECT_EQ(state(), Liveness::kResting);
  EXPECT_EQ(sentence(), "There are no viewers, so no picture is rendered.");
  pass(2500);
  EXPECT_EQ(state(), Liveness::kNotLive);
  EXPECT_EQ(cause(), Cause::kNoFrames);
  sweep(true, false);
  source_.resting = false;
  update();
  EXPECT_EQ(state(), Liveness::kWaiting) << "the picture of before the rest is not on show";
  EXPECT_EQ(sentence(), "The picture is being rendered.");
  sweep();
  EXPECT_EQ(state(), Liveness::kLive);
}

TEST_F(LivenessTest, ARelitVolumeStaysOld) {
  sweep();
  const std::int64_t captured_ns = now_ns_;
  for (int moves = 0; moves < 30; ++moves) {
    pass(100);
    show(captured_ns);
  }
  EXPECT_EQ(state(), Liveness::kNotLive);
  EXPECT_NEAR(liveness_.report().age_s, 3, 0.3);
}

TEST_F(LivenessTest, SilenceOfTheSourceIsSeenInTwoSeconds) {
  sweep();
  pass(1900);
  EXPECT_EQ(state(), Liveness::kLive);
  pass(500);
  EXPECT_EQ(state(), Liveness::kNotLive);
  EXPECT_EQ(cause(), Cause::kNoFrames);
  EXPECT_EQ(sentence(), "The source has sent no frame for 2 s.");
  sweep();
  EXPECT_EQ(state(), Liveness::kLive);
}

TEST_F(LivenessTest, DroppedSweepsAreTheCause) {
  sweep();
  EXPECT_LE(ms_until_not_live(false, false), 2250);
  EXPECT_EQ(cause(), Cause::kSweepsDropped);
  EXPECT_EQ(sentence(), "Every sweep is missing too many frames: 11 dropped in 2 s.");
}

TEST_F(LivenessTest, FramesWithoutTheEndOfASweepAreTheCause) {
  sweep();
  for (int frame = 0; frame < 300; ++frame) {
    now_ns_ += 10 * kMs;
    acquisition_.frames_received.add();
    update();
  }
  EXPECT_EQ(cause(), Cause::kNoSweep);
}

TEST_F(LivenessTest, ARendererThatFinishesNothingIsTheCause) {
  sweep();
  EXPECT_LE(ms_until_not_live(true, false), 2250);
  EXPECT_EQ(cause(), Cause::kRendererBehind);
}

TEST_F(LivenessTest, RefusedVolumesAreTheCauseWithItsReason) {
  sweep();
  liveness_.health_changed({.cause = "", .volume_refusal = "2.1 GB are needed, expected at most 2 GB"});
  for (int volume = 0; volume < 15; ++volume) {
    sweep(true, false);
    render_.volumes_refused.add();
  }
  update();
  EXPECT_EQ(cause(), Cause::kVolumesRefused);
  EXPECT_EQ(sentence(), "The GPU refuses every volume: 2.1 GB are needed, expected at most 2 GB.");
}

TEST_F(LivenessTest, ASlowRendererDelaysThePictures) {
  sweep();
  for (int volume = 0; volume < 12; ++volume) {
    for (int missed = 0; missed < 6; ++missed) sweep(true, false);
    show(now_ns_ - 4000 * kMs);  // it took four seconds
    update();
  }
  EXPECT_EQ(state(), Liveness::kDelayed);
  EXPECT_NEAR(liveness_.report().age_s, 4, 0.3);
  EXPECT_EQ(sentence(), "The renderer is slower than the probe: 0.8 pictures a second.");
}

TEST_F(LivenessTest, ADelayIsNotLaidToTheRendererWhereOthersAreLate) {
  sweep();
  const auto delay_from = [this](std::int64_t age_ms) {
    for (int volume = 0; volume < 12; ++volume) {
      now_ns_ += sweep_ms_ * kMs;
      acquisition_.frames_received.add(20);
      ring_.volumes_published.add();
      update();
      PictureStamp stamp;
      stamp.volume = {.volume_id = ring_.volumes_published.value(),
                      .frames = 20,
                      .first_capture_time_ns = now_ns_ - (age_ms + sweep_ms_) * kMs,
                      .last_capture_time_ns = now_ns_ - age_ms * kMs};
      liveness_.shown(stamp, now_ns_);
      update();
    }
  };
  acquisition_.frame_age_s.set(5);
  delay_from(5000);
  EXPECT_EQ(state(), Liveness::kDelayed);
  EXPECT_EQ(sentence(), "The source's frames are 5.0 s old when they come.");
  acquisition_.frame_age_s.set(0);
  acquisition_.volumes_incomplete.add();
  update();
  EXPECT_EQ(sentence(), "The last sweep is missing too many frames.");
  pass(1250);
  EXPECT_EQ(state(), Liveness::kDelayed);
  EXPECT_EQ(sentence(), "The source has sent no frame for 1.2 s.");
}

TEST_F(LivenessTest, FramesOfARecordingAreNotLiveBehindARelay) {
  source_.origin = FrameOrigin::kUnknown;
  sweep();
  EXPECT_EQ(state(), Liveness::kLive);
  EXPECT_EQ(sentence(), "The picture is live as far as the sender of the frames says.");
  source_.origin = FrameOrigin::kSimulated;
  EXPECT_TRUE(update()) << "to be reported";
  EXPECT_EQ(sentence(), "The picture is live, of a simulated probe.");
  source_.origin = FrameOrigin::kRecording;
  EXPECT_TRUE(update());
  EXPECT_EQ(state(), Liveness::kReplay);
  EXPECT_FALSE(liveness_.report().live());
  EXPECT_EQ(sentence(), "The sender of the frames plays a recording.");
  pass(3000);
  EXPECT_EQ(state(), Liveness::kNotLive);
  EXPECT_EQ(cause(), Cause::kNoFrames);
}

TEST_F(LivenessTest, AChangeThatIsNotShownIsToldBesideTheState) {
  sweep();
  source_.scene_trouble = "The last change is not shown yet: the renderer is still working on it.";
  EXPECT_TRUE(update());
  EXPECT_EQ(state(), Liveness::kLive);
  EXPECT_EQ(cause(), Cause::kChangeNotShown);
  EXPECT_EQ(sentence(), "The picture is live. " + source_.scene_trouble);
  source_.scene_trouble.clear();
  EXPECT_TRUE(update());
  EXPECT_EQ(cause(), Cause::kNone);
}

TEST_F(LivenessTest, ALostGpuIsMissingUntilItsNewDeviceShowsAPicture) {
  sweep();
  RenderHealth health{.state = RenderHealth::State::kRemaking, .since_ns = now_ns_, .devices_lost = 1};
  health.cause = "a submission was lost";
  liveness_.health_changed(health);
  pass(250);
  EXPECT_EQ(cause(), Cause::kGpuRemade);
  PictureStamp late;
  late.volume = {.volume_id = 1, .last_capture_time_ns = now_ns_};
  late.finished_time_ns = now_ns_ - 500 * kMs;  // by the device that is lost
  health.state = RenderHealth::State::kRunning;
  health.since_ns = now_ns_;
  liveness_.health_changed(health);
  liveness_.shown(late, now_ns_);
  for (int volume = 0; volume < 25; ++volume) sweep(true, false);
  EXPECT_EQ(cause(), Cause::kGpuRemade) << "the new device has shown nothing";
  EXPECT_NEAR(static_cast<double>(liveness_.gpu_lost_ns()), 5.25e9, 0.3e9);
  now_ns_ += 3'600'000 * kMs;  // the process was stopped
  update();
  EXPECT_LT(liveness_.gpu_lost_ns(), 8'000 * kMs);
  source_.resting = true;
  acquisition_.frames_received.add();
  update();
  EXPECT_EQ(cause(), Cause::kNone) << "without viewers no picture is expected";
  EXPECT_EQ(liveness_.gpu_lost_ns(), 0);
  source_.resting = false;
  update();
  EXPECT_EQ(cause(), Cause::kGpuRemade);
  sweep();
  EXPECT_EQ(state(), Liveness::kLive);
  EXPECT_EQ(liveness_.gpu_lost_ns(), 0);
}

TEST_F(LivenessTest, ALostGpuWithNothingToShowIsNotWaitedFor) {
  sweep();
  RenderHealth health{.state = RenderHealth::State::kRunning, .since_ns = now_ns_, .devices_lost = 1};
  liveness_.health_changed(health);
  pass(5000);
  EXPECT_EQ(cause(), Cause::kNoFrames) << "no volume has come since";
  EXPECT_EQ(liveness_.gpu_lost_ns(), 0);
  sweep(true, false);
  EXPECT_EQ(cause(), Cause::kGpuRemade);
  render_.volumes_refused.add();
  sweep(true, false);
  EXPECT_EQ(liveness_.gpu_lost_ns(), 0) << "the new device works, and has no room";
}

TEST_F(LivenessTest, SlowSweepsAreLiveForThreeOfThem) {
  sweep_ms_ = 3000;
  sweep();
  EXPECT_EQ(liveness_.limit_ns(), 9000 * kMs);
  sweep(false);
  sweep(false);
  EXPECT_EQ(state(), Liveness::kLive);
  sweep(false);
  sweep(false);
  EXPECT_EQ(state(), Liveness::kNotLive);
  EXPECT_EQ(cause(), Cause::kSweepsDropped);
}

TEST_F(LivenessTest, WhatIsKnownAtOnceIsSaidAtOnce) {
  struct Row {
    PictureLiveness::Source source;
    RenderHealth health;
    Cause cause;
    const char* sentence;
  };
  using Source = PictureLiveness::Source::State;
  using Health = RenderHealth::State;
  const RenderHealth well;
  const Row rows[] = {
      {{.state = Source::kFailed, .failure = "the file ends early", .probe_lost = false},
       well,
       Cause::kSourceFailed,
       "The source has failed: the file ends early."},
      {{.state = Source::kEnded, .failure = "", .probe_lost = false},
       well,
       Cause::kSourceEnded,
       "The recording has ended."},
      {{.state = Source::kRunning, .failure = "", .probe_lost = true},
       well,
       Cause::kProbeLost,
       "The probe is lost."},
      {{.failure = ""},
       {.state = Health::kHung, .cause = "no answer for 10 s"},
       Cause::kGpuHung,
       "The GPU does not answer: no answer for 10 s."},
      {{.failure = ""},
       {.state = Health::kRemaking, .cause = "the device was lost"},
       Cause::kGpuRemade,
       "The GPU was lost and is started again: the device was lost."},
  };
  for (const Row& row : rows) {
    source_ = {};
    liveness_.health_changed(well);
    sweep();
    ASSERT_EQ(state(), Liveness::kLive) << row.sentence;
    source_ = row.source;
    liveness_.health_changed(row.health);
    EXPECT_TRUE(update()) << "displays must be told: " << row.sentence;
    EXPECT_EQ(state(), Liveness::kNotLive) << row.sentence;
    EXPECT_EQ(cause(), row.cause) << row.sentence;
    EXPECT_EQ(sentence(), row.sentence);
    EXPECT_FALSE(update()) << "nothing has changed: " << row.sentence;
  }
}

TEST_F(LivenessTest, ASlowGpuIsNoCause) {
  sweep();
  liveness_.health_changed({.state = RenderHealth::State::kSlow, .cause = ""});
  sweep();
  EXPECT_EQ(state(), Liveness::kLive);
}

TEST_F(LivenessTest, SaysThatTheDriverIsSilent) {
  for (int each = 0; each < 3; ++each) sweep();
  render_.turn_began_ns.set(now_ns_);
  pass(1'000);
  EXPECT_EQ(state(), Liveness::kLive);
  pass(2'000);
  EXPECT_EQ(cause(), Cause::kDriverSilent);
  EXPECT_EQ(sentence(), "The GPU's driver has not answered for 3 s.");
  EXPECT_EQ(liveness_.driver_silent_ns(), 2'750 * kMs) << "from the first look";
  render_.turn_began_ns.set(now_ns_);
  update();
  EXPECT_NE(cause(), Cause::kDriverSilent);

  source_.resting = true;
  for (int each = 0; each < 20; ++each) sweep(true, false);
  EXPECT_EQ(cause(), Cause::kDriverSilent) << "a rest asks nothing of the driver, and does not hide it";
  EXPECT_EQ(state(), Liveness::kNotLive);
}

TEST(DriverWatchTest, CountsOnlyTheTimeInWhichItLooks) {
  DriverWatch watch;
  watch.observe(5, 1'000 * kMs);
  watch.observe(5, 1'500 * kMs);
  EXPECT_EQ(watch.silent_ns(), 500 * kMs);
  watch.observe(5, 3'600'000 * kMs);  // the process was stopped for an hour
  EXPECT_EQ(watch.silent_ns(), 500 * kMs + DriverWatch::kMostGapNs);
  watch.observe(6, 3'600'500 * kMs);
  EXPECT_EQ(watch.silent_ns(), 0);
  watch.observe(0, 3'601'000 * kMs);
  watch.observe(0, 3'602'000 * kMs);
  EXPECT_EQ(watch.silent_ns(), 0) << "it rests";
}

}  // namespace
}  // namespace fanlight::test
