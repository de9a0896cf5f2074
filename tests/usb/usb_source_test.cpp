// SPDX-License-Identifier: Apache-2.0
// The libusb source with the emulated probe: normal reading, and the reaction to every fault.

#include "acquisition/usb/usb_source.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>

#include "proto/base/clock.hpp"
#include "tests/usb/source_rig.hpp"

namespace fanlight::test {
namespace {

using Frame = SourceRig::Frame;

std::vector<std::uint64_t> sequences(const std::vector<Frame>& frames) {
  std::vector<std::uint64_t> numbers;
  for (const Frame& frame : frames) numbers.push_back(frame.stamp.sequence);
  return numbers;
}

std::size_t count(const std::vector<Frame>& frames, FrameFault fault) {
  return static_cast<std::size_t>(std::ranges::count(frames, fault, &Frame::fault));
}

TEST(UsbSource, ReadsEveryFrameInOrder) {
  SourceRig rig;
  ASSERT_TRUE(rig.open());
  EXPECT_EQ(rig.source->description().name, "usb:1209:0001");
  EXPECT_EQ(rig.source->description().geometry.columns, 64U);
  const auto frames = rig.next(45);
  for (std::size_t at = 0; at < frames.size(); ++at) {
    const Frame& frame = frames[at];
    EXPECT_EQ(frame.fault, FrameFault::kNone);
    EXPECT_EQ(frame.stamp.sequence, at);
    EXPECT_EQ(frame.stamp.volume_index, at / 10);
    EXPECT_EQ(frame.stamp.frame_index, at % 10);
    EXPECT_EQ(frame.stamp.frames_in_sweep, 10U);
    EXPECT_EQ(frame.stamp.direction == SweepDirection::kForward, at / 10 % 2 == 0);
    EXPECT_EQ(frame.stamp.after_interruption, at == 0);
    EXPECT_LE(frame.stamp.capture_time_ns, now_ns());
    EXPECT_GT(*std::ranges::max_element(frame.pixels), 0) << "there is a picture in it";
  }
  // The probe sweeps 70 deg, forward and backward.
  EXPECT_NEAR(degrees(frames[0].stamp.angle_rad), -35, 1e-5);
  EXPECT_NEAR(degrees(frames[9].stamp.angle_rad), 35, 1e-5);
  EXPECT_NEAR(degrees(frames[10].stamp.angle_rad), 35, 1e-5);
  EXPECT_EQ(rig.status().state, ProbeStatus::State::kStreaming);
  EXPECT_EQ(rig.status().identity.serial, "0001");
  EXPECT_EQ(rig.counters().bytes_skipped.value(), 0U);
  EXPECT_EQ(rig.counters().probes_found.value(), 1U);
}

TEST(UsbSource, ADamagedFrameIsThatFrameAlone) {
  SourceRig rig("frame 12 damage");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(20);
  EXPECT_EQ(frames[12].fault, FrameFault::kDamaged);
  EXPECT_EQ(count(frames, FrameFault::kNone), 19U);
}

TEST(UsbSource, ACutFrameIsThatFrameAlone) {
  SourceRig rig("frame 12 cut");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(20);
  EXPECT_EQ(frames[12].fault, FrameFault::kCut);
  EXPECT_EQ(count(frames, FrameFault::kNone), 19U);
  EXPECT_EQ(rig.counters().transfers_short.value(), 1U);
}

TEST(UsbSource, AFrameThatTheProbeFlagsIsInvalid) {
  SourceRig rig("frame 12 invalid");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(20);
  EXPECT_EQ(frames[12].fault, FrameFault::kInvalid);
  EXPECT_EQ(count(frames, FrameFault::kNone), 19U);
}

TEST(UsbSource, AFrameOfAnUnknownGeometryIsAMisfit) {
  SourceRig rig("frame 12 misfit");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(20);
  EXPECT_EQ(frames[12].fault, FrameFault::kMisfit);
  EXPECT_EQ(count(frames, FrameFault::kNone), 19U);
}

TEST(UsbSource, ADamagedHeaderIsAGapAndSkippedBytes) {
  SourceRig rig("frame 12 damage-header");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(20);
  EXPECT_EQ(frames[11].stamp.sequence, 11U);
  EXPECT_EQ(frames[12].stamp.sequence, 13U);
  EXPECT_EQ(count(frames, FrameFault::kNone), 20U);
  EXPECT_EQ(rig.counters().bytes_skipped.value(), probe::kFrameHeaderBytes + 64 * 64);
}

TEST(UsbSource, NoiseIsSkipped) {
  SourceRig rig("frame 12 noise 1000");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(20);
  EXPECT_EQ(count(frames, FrameFault::kNone), 20U);
  EXPECT_EQ(frames[19].stamp.sequence, 19U);
  EXPECT_EQ(rig.counters().bytes_skipped.value(), 1000U);
}

TEST(UsbSource, LostRepeatedAndSwappedFramesShowInTheSequence) {
  SourceRig rig("frame 5 drop; frame 8 repeat; frame 12 swap");
  ASSERT_TRUE(rig.open());
  const auto numbers = sequences(rig.next(16));
  const std::set<std::uint64_t> seen(numbers.begin(), numbers.end());
  EXPECT_FALSE(seen.contains(5)) << "lost";
  EXPECT_EQ(std::ranges::count(numbers, 8U), 2) << "repeated";
  EXPECT_FALSE(std::ranges::is_sorted(numbers)) << "swapped";
}

TEST(UsbSource, AHaltedPipeIsClearedAndReadOn) {
  SourceRig rig("frame 12 stall");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(30);
  EXPECT_EQ(rig.counters().transfers_stalled.value(), 1U);
  EXPECT_GE(count(frames, FrameFault::kNone), 28U) << "at most the frame under way is lost";
  EXPECT_EQ(std::ranges::count_if(frames, [](const Frame& frame) { return frame.stamp.after_interruption; }),
            1)
      << "the stream continues";
  EXPECT_EQ(rig.counters().probes_lost.value(), 0U);
}

TEST(UsbSource, AnErrorOnTheBusCostsAFrameOrTwo) {
  SourceRig rig("frame 12 error");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(30);
  EXPECT_EQ(rig.counters().transfers_failed.value(), 1U);
  EXPECT_GE(count(frames, FrameFault::kNone), 28U);
  EXPECT_EQ(rig.counters().probes_lost.value(), 0U);
}

TEST(UsbSource, AnOverflowCostsAFrameOrTwo) {
  SourceRig rig("frame 12 overflow");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(30);
  EXPECT_EQ(rig.counters().transfers_overflowed.value(), 1U);
  EXPECT_GE(count(frames, FrameFault::kNone), 28U);
  EXPECT_EQ(rig.counters().probes_lost.value(), 0U);
}

TEST(UsbSource, ASilentProbeIsStartedAgain) {
  SourceRig rig("frame 12 silent 2s");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(30);
  EXPECT_EQ(rig.counters().transfers_timed_out.value(), 1U);
  EXPECT_EQ(rig.counters().streams_restarted.value(), 1U);
  EXPECT_TRUE(frames[12].stamp.after_interruption);
  EXPECT_EQ(count(frames, FrameFault::kNone), 30U);
  const auto numbers = sequences(frames);
  EXPECT_TRUE(std::ranges::is_sorted(numbers)) << "numbers continue over a restart";
  EXPECT_EQ(std::ranges::adjacent_find(numbers), numbers.end());
  EXPECT_EQ(rig.counters().probes_lost.value(), 0U);
}

TEST(UsbSource, AProbeThatStaysSilentIsResetAndTakenAnew) {
  SourceRig rig("frame 12 silent 8s");
  ASSERT_TRUE(rig.open());
  const auto frames = rig.next(20);
  EXPECT_GE(rig.counters().transfers_timed_out.value(), 4U);
  EXPECT_GE(rig.counters().probes_lost.value(), 1U);
  EXPECT_EQ(rig.counters().probes_found.value(), 1 + rig.counters().probes_lost.value());
  EXPECT_TRUE(frames[12].stamp.after_interruption);
  EXPECT_EQ(count(frames, FrameFault::kNone), 20U);
}

TEST(UsbSource, AProbeThatRestartsByItselfShowsInTheSequence) {
  SourceRig rig("frame 12 restart");
  ASSERT_TRUE(rig.open());
  // A slow reader misses the first frames: the numbers fall once, wherever it began.
  const auto numbers = sequences(rig.next(40));
  std::size_t falls = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) falls += numbers[i] < numbers[i - 1] ? 1 : 0;
  EXPECT_EQ(falls, 1U);
}

TEST(UsbSource, AGeometryThatChangesInMidStreamComesWithItsFrames) {
  SourceRig rig("frame 14 geometry");
  ASSERT_TRUE(rig.open());
  const FanGeometry before = rig.source->description().geometry;
  const auto frames = rig.next_until([&] { return rig.source->description().geometry != before; });
  const auto after = rig.next(20);
  EXPECT_NE(after[0].stamp.geometry_revision, frames[0].stamp.geometry_revision);
  EXPECT_EQ(count(frames, FrameFault::kNone), frames.size());
  EXPECT_EQ(count(after, FrameFault::kNone), after.size());
  EXPECT_EQ(after[5].pixels.size(), rig.source->description().geometry.frame_bytes());
}

TEST(UsbSource, SettingsAreMadeBeforeTheFirstFrame) {
  SourceRig rig;
  ASSERT_TRUE(rig.open({.sweep_deg = 40, .frames_a_volume = 8, .depth_mm = 100}));
  EXPECT_NEAR(degrees(rig.source->description().last_angle_rad), 20, 1e-9);
  EXPECT_NEAR(rig.source->description().geometry.depth_mm(), 100, 3);
  const auto frames = rig.next(10);
  EXPECT_EQ(frames[0].stamp.frames_in_sweep, 8U);
  EXPECT_NEAR(degrees(frames[0].stamp.angle_rad), -20, 1e-5);
  EXPECT_EQ(count(frames, FrameFault::kNone), 10U);
  EXPECT_EQ(rig.counters().settings_taken.value(), 1U);
}

TEST(UsbSource, ASettingOutOfTheProbesRangeIsRefusedWithTheRange) {
  SourceRig rig;
  const auto opened = rig.open({.sweep_deg = 400});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(opened.error().message.find("the probe's sweep was to be 400 deg, expected "), 0U)
      << opened.error().message;
}

TEST(UsbSource, AnOrderInMidStreamIsAnswered) {
  SourceRig rig;
  ASSERT_TRUE(rig.open());
  rig.next(3);
  const auto order = [&rig](std::uint64_t number, const probe::Settings& settings) {
    rig.link.orders.draft() = {.number = number, .settings = settings};
    rig.link.orders.publish();
    rig.next_until([&rig, number] { return rig.status().order_answered == number; });
  };
  order(1, {.sweep_deg = 50, .frames_a_volume = 12, .depth_mm = 160});
  EXPECT_EQ(rig.status().refusal, "");
  EXPECT_EQ(rig.status().settings.frames_a_volume, 12U);
  const auto frames = rig.next_until([&rig] { return rig.next().stamp.frames_in_sweep == 12; });
  EXPECT_EQ(count(frames, FrameFault::kNone), frames.size());

  order(2, {.sweep_deg = 50, .frames_a_volume = 5000, .depth_mm = 160});
  EXPECT_NE(rig.status().refusal.find("frames a volume was to be 5000, expected 2 to"), std::string::npos)
      << rig.status().refusal;
  EXPECT_EQ(rig.status().settings.frames_a_volume, 12U);
  EXPECT_EQ(rig.counters().settings_refused.value(), 1U);
}

struct Hotplug : testing::TestWithParam<EmulatedBus::Udev> {};

TEST_P(Hotplug, AProbeThatIsUnpluggedIsTakenAgainWithItsSettings) {
  SourceRig rig("", SourceRig::small(), GetParam());
  ASSERT_TRUE(rig.open({.frames_a_volume = 8}));
  std::uint64_t last_sequence = rig.next(30).back().stamp.sequence;
  for (std::uint64_t round = 1; round <= 3; ++round) {
    rig.probe->unplug();
    std::jthread replug([&rig, round] {
      while (rig.counters().probes_lost.value() < round) std::this_thread::yield();
      rig.probe->plug();
    });
    const auto frames =
        rig.next_until([&rig, round] { return rig.counters().probes_found.value() == round + 1; });
    const auto back = rig.next(8);
    const auto interrupted =
        std::ranges::find_if(frames, [](const Frame& frame) { return frame.stamp.after_interruption; });
    ASSERT_NE(interrupted, frames.end());
    EXPECT_GT(interrupted->stamp.sequence, last_sequence) << "no number comes twice";
    EXPECT_EQ(interrupted->stamp.frame_index, 0U) << "a sweep begins";
    EXPECT_EQ(interrupted->stamp.frames_in_sweep, 8U) << "as it was set before";
    EXPECT_EQ(count(back, FrameFault::kNone), back.size());
    last_sequence = back.back().stamp.sequence;
    EXPECT_EQ(rig.status().state, ProbeStatus::State::kStreaming);
    EXPECT_EQ(rig.status().times_lost, round);
  }
}

INSTANTIATE_TEST_SUITE_P(Udev, Hotplug, testing::Values(EmulatedBus::Udev::kOn, EmulatedBus::Udev::kOff),
                         [](const auto& tested) {
                           return tested.param == EmulatedBus::Udev::kOn ? "on" : "off";
                         });

TEST(UsbSource, AStopEndsTheWaitForAProbe) {
  SourceRig rig;
  ASSERT_TRUE(rig.open());
  rig.next(5);
  rig.probe->unplug();
  std::jthread stopper([&rig] {
    while (rig.counters().probes_lost.value() == 0) std::this_thread::yield();
    rig.stop.request_stop();
  });
  for (;;) {
    const auto frame = rig.source->next_frame(rig.stop.get_token());
    ASSERT_TRUE(frame);
    if (!*frame) break;
  }
  EXPECT_EQ(rig.status().state, ProbeStatus::State::kLost);
}

TEST(UsbSource, AnOrderForALostProbeIsRefused) {
  SourceRig rig;
  ASSERT_TRUE(rig.open());
  rig.next(5);
  rig.probe->unplug();
  rig.link.orders.draft() = {.number = 1,
                             .settings = {.sweep_deg = 50, .frames_a_volume = 12, .depth_mm = 160}};
  std::jthread orderer([&rig] {
    while (rig.counters().probes_lost.value() == 0) std::this_thread::yield();
    rig.link.orders.publish();
    while (rig.status().order_answered == 0) std::this_thread::yield();
    rig.stop.request_stop();
  });
  while (*rig.source->next_frame(rig.stop.get_token())) {
  }
  EXPECT_EQ(rig.status().refusal, "the probe is not connected, expected one");
}

TEST(UsbSource, SaysThatNoSuchProbeIsThere) {
  SourceRig rig;
  rig.probe->unplug();
  const auto absent = rig.open({}, "", 0);
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(
      absent.error().message,
      "no device usb:1209:0001 is connected, expected a probe with that vendor, product and serial number "
      "(see lsusb)");
  rig.probe->plug();
  const auto other = rig.open({}, "0009", 0);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().message, "the device found has the serial number \"0001\", expected \"0009\"");
}

TEST(UsbSource, WaitsForAProbeThatComesLater) {
  SourceRig rig;
  rig.probe->unplug();
  std::jthread plugger([&rig] {
    // A sleep, because nothing shows that the source has begun to search. The test may also plug in too
    // early, and then passes too.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    rig.probe->plug();
  });
  EXPECT_TRUE(rig.open({}, "", 60));
}

TEST(UsbSource, TakesTheProbeWithTheSerialNumberAskedFor) {
  SourceRig rig;
  auto model = SourceRig::small();
  model.serial = "0002";
  const auto second = UsbfsProbe::create(rig.bus, {.model = model}).value();
  second->plug();
  ASSERT_TRUE(rig.open({}, "0002"));
  rig.next(5);
  EXPECT_EQ(rig.status().identity.serial, "0002");
  EXPECT_TRUE(second->streaming());
  EXPECT_FALSE(rig.probe->streaming());
}

TEST(UsbSource, AnotherProbeThatDoesNotFitIsNotReadAndSaidSo) {
  SourceRig rig;
  ASSERT_TRUE(rig.open());
  rig.next(5);
  auto larger = SourceRig::small();
  larger.serial = "0002";
  larger.columns = larger.rows = 128;
  const auto other = UsbfsProbe::create(rig.bus, {.model = larger}).value();
  rig.probe->unplug();
  other->plug();
  std::jthread replacer([&] {
    while (rig.status().trouble.empty()) std::this_thread::yield();
    other->unplug();
    rig.probe->plug();
  });
  const auto frames = rig.next_until([&] { return rig.counters().probes_found.value() == 2; });
  EXPECT_FALSE(other->streaming());
  EXPECT_EQ(count(rig.next(10), FrameFault::kNone), 10U);
  replacer.join();
  EXPECT_EQ(rig.status().trouble, "") << "it is over";
  EXPECT_EQ(rig.status().state, ProbeStatus::State::kStreaming);
}

TEST(UsbSource, AProbeThatDoesNotAnswerIsAskedAgain) {
  SourceRig rig;
  // Not by a script: its thread may come after the first question.
  rig.probe->inject({.kind = FaultKind::kLateIdentity});
  ASSERT_TRUE(rig.open({}, "", 60)) << "the second question is answered";
  EXPECT_EQ(rig.counters().requests_failed.value(), 1U);
  EXPECT_EQ(count(rig.next(10), FrameFault::kNone), 10U);
}

// Continuous random bytes are no stream: the source restarts the probe, resets it, loses and reopens it, as
// long as they last, and does nothing else.
TEST(UsbSource, RandomBytesAreNoFramesAndDoNoHarm) {
  SourceRig rig;
  ASSERT_TRUE(rig.open());
  rig.next(5);
  rig.probe->inject({.kind = FaultKind::kRandom});
  // A start ends the random bytes; the frames after it prove that the source still works.
  const auto frames = rig.next_until([&rig] { return rig.counters().streams_restarted.value() > 0; });
  EXPECT_GT(rig.counters().bytes_skipped.value(), 0U);
  EXPECT_EQ(count(rig.next(10), FrameFault::kNone), 10U);
}

}  // namespace
}  // namespace fanlight::test
