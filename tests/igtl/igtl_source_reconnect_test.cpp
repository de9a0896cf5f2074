// SPDX-License-Identifier: Apache-2.0
// The OpenIGTLink source where what it has learned holds no more, and where it is stopped before.
#include "tests/igtl/igtl_source_rig.hpp"

namespace fanlight::test {
namespace igtl_source_tests {

/// The transform of an image, seen from a tracker that was moved and turned by a right angle.
Bytes transform_of_moved_tracker(std::uint32_t index) {
  const double angle = radians(angle_deg(index, kFrames));
  return transform_message("ProbeToTracker", kBeganMs + 40 * index,
                           {.i_mm = {0, 1, 0},
                            .j_mm = {-std::cos(angle), 0, std::sin(angle)},
                            .k_mm = {std::sin(angle), 0, std::cos(angle)},
                            .first_mm = {500, -300, 200}});
}

TEST(IgtlSourceReconnect, FitsTheFanAgainWhereTheTrackerWasMoved) {
  Rig rig;
  std::vector<Bytes> first;
  for (std::uint32_t i = 0; i < 64; ++i) {
    first.push_back(transform_of_plus(i));
    first.push_back(message_of(of_plus(i)));
  }
  ASSERT_TRUE(rig.open(first)) << rig.error.message;
  ASSERT_EQ(rig.next(1).size(), 1U);
  std::thread scanner([&] {
    for (std::uint32_t i = 64; i < 264; ++i) {
      // A knock at the tracker is no other fan: they must lie beside the old one for 2 s.
      if (i < 104) std::this_thread::sleep_for(std::chrono::milliseconds(60));
      EXPECT_TRUE(rig.scanner.send(transform_of_moved_tracker(i)));
      EXPECT_TRUE(rig.scanner.send(message_of(of_plus(i))));
    }
  });
  const auto frames = rig.next(1000);
  scanner.join();
  std::size_t invalid = 0;
  for (const Frame& frame : frames) invalid += frame.fault == FrameFault::kInvalid ? 1 : 0;
  EXPECT_GE(invalid, 20U) << "the probe may have slipped out of view for a moment";
  ASSERT_GT(frames.size(), invalid + 20) << "and then they are frames again";
  for (std::size_t i = frames.size() - 20; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].fault, FrameFault::kNone);
    EXPECT_LE(std::abs(degrees(frames[i].stamp.angle_rad)), 20.1);
  }
  EXPECT_GT(frames.back().stamp.geometry_revision, frames.front().stamp.geometry_revision);
  EXPECT_EQ(rig.status().trouble, "");
}

TEST(IgtlSourceReconnect, FramesThatAreLateAfterALossLookLate) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0)), message_of(of_fanlight(1))}));
  ASSERT_EQ(rig.next(2).size(), 2U);
  const std::int64_t began_ns = now_ns();
  rig.scanner.hang_up();
  std::thread again([&] {
    EXPECT_TRUE(rig.scanner.accept());
    // The relay has kept this frame, which was taken 10 ms after the last one.
    EXPECT_TRUE(rig.scanner.send(message_of(of_fanlight(2))));
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  const auto frames = rig.next(1);
  again.join();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_LT(frames[0].stamp.capture_time_ns, began_ns + 300'000'000);
}

TEST(IgtlSource, AFrameIsAsOldAsItsSenderSays) {
  Rig rig;
  SentImage old = of_fanlight(0);
  old.metadata.emplace_back(plus_field::kAgeMs, "4000");
  ASSERT_TRUE(rig.open({message_of(old)}));
  const auto frames = rig.next(1);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_LE(frames[0].stamp.capture_time_ns, now_ns() - 4'000'000'000);
}

TEST(IgtlSource, TellsWhereItsFramesComeFrom) {
  Rig rig;
  ASSERT_TRUE(rig.open({message_of(of_fanlight(0))}));
  EXPECT_EQ(rig.source->description().origin, FrameOrigin::kUnknown);
  std::uint32_t index = 0;
  const auto origin_after = [&](const char* told) {
    SentImage sent = of_fanlight(++index);
    if (told != nullptr) sent.metadata.emplace_back(plus_field::kOrigin, told);
    EXPECT_TRUE(rig.scanner.send(message_of(sent)));
    EXPECT_FALSE(rig.next(index == 1 ? 2 : 1).empty());
    return rig.status().origin;
  };
  EXPECT_EQ(origin_after(nullptr), std::nullopt);
  EXPECT_EQ(origin_after("recording"), FrameOrigin::kRecording);
  EXPECT_EQ(origin_after("probe"), FrameOrigin::kProbe);
  EXPECT_EQ(origin_after("simulated"), FrameOrigin::kSimulated);
  EXPECT_EQ(origin_after("something new"), std::nullopt);
}

TEST(IgtlSourceReconnect, StopsBeforeItKnowsTheImages) {
  for (const bool connects : {false, true}) {
    Rig rig;
    IgtlSource::Config config;
    std::atomic<int> asked = 0;
    config.stopped = [&] { return ++asked > (connects ? 3 : 0); };
    if (connects) {
      EXPECT_FALSE(rig.open({}, "", config));
    } else {
      config.address = *IgtlAddress::parse("127.0.0.1:1");
      const auto opened = IgtlSource::create(config, rig.link);
      ASSERT_FALSE(opened);
      rig.error = opened.error();
    }
    EXPECT_EQ(rig.error.code, ErrorCode::kStopped);
  }
}

}  // namespace igtl_source_tests
}  // namespace fanlight::test
