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
