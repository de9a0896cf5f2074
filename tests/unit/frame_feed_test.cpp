#include "proto/frame_feed.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <set>
#include <stop_token>
#include <thread>
#include <vector>

namespace fanlight {
namespace {

constexpr std::uint32_t kSlots = 4;
constexpr std::uint32_t kRows = 16;
constexpr std::uint32_t kMostColumns = 12;

/// Frames differ in size, and neighbours, as well as frames that share a slot, in every pixel.
FanGeometry geometry_of(std::uint64_t arrival) {
  return {.columns = kMostColumns - static_cast<std::uint32_t>(arrival % 5),
          .rows = kRows,
          .pixel_width_mm = 1,
          .pixel_height_mm = 1,
          .motor_radius_mm = 30};
}

std::uint8_t pixel_of(std::uint64_t arrival, std::uint64_t index) {
  return static_cast<std::uint8_t>(7 * arrival + (arrival >> 8) + 3 * index);
}

double angle_of(std::uint64_t arrival) {
  return 0.001 * static_cast<double>(arrival);
}

/// False where the feed did not take it.
bool put(FrameFeed& feed, std::uint64_t arrival) {
  const FanGeometry geometry = geometry_of(arrival);
  std::vector<std::uint8_t> pixels(geometry.frame_bytes());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = pixel_of(arrival, i);
  return feed.put({.sequence = 1000 + arrival, .angle_rad = angle_of(arrival), .arrival = arrival}, geometry,
                  pixels);
}

void expect_whole(const FedFrame& frame) {
  const std::uint64_t arrival = frame.stamp.arrival;
  ASSERT_EQ(frame.stamp.sequence, 1000 + arrival);
  ASSERT_EQ(frame.stamp.angle_rad, angle_of(arrival));
  ASSERT_EQ(frame.geometry, geometry_of(arrival));
  ASSERT_EQ(frame.pixels.size(), frame.geometry.frame_bytes());
  for (std::size_t i = 0; i < frame.pixels.size(); ++i) {
    ASSERT_EQ(frame.pixels[i], pixel_of(arrival, i)) << "a torn frame";
  }
}

class FrameFeedTest : public testing::Test {
 protected:
  void expect_next(std::uint64_t arrival) {
    const FedFrame* const frame = feed_.front();
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->stamp.arrival, arrival);
    expect_whole(*frame);
    feed_.pop();
  }

  Doorbell bell_;
  FrameFeed feed_{{.largest_frame_bytes = kMostColumns * kRows, .slots = kSlots}, {.reader_bell = bell_}};
};

TEST_F(FrameFeedTest, IsEmptyAtFirst) {
  EXPECT_EQ(feed_.front(), nullptr);
  EXPECT_FALSE(bell_.wait(0));
}

TEST_F(FrameFeedTest, GivesFramesInOrderAndRingsTheBell) {
  EXPECT_TRUE(put(feed_, 1));
  EXPECT_TRUE(bell_.wait(0));
  EXPECT_TRUE(put(feed_, 2));
  EXPECT_TRUE(bell_.wait(0));
  EXPECT_TRUE(put(feed_, 3));
  expect_next(1);
  expect_next(2);
  expect_next(3);
  EXPECT_EQ(feed_.front(), nullptr);
  EXPECT_EQ(feed_.counters().frames_fed.value(), 3U);
  EXPECT_EQ(feed_.counters().frames_not_fed.value(), 0U);
}

TEST_F(FrameFeedTest, AFullFeedKeepsWhatItHasAndCountsTheRest) {
  for (std::uint64_t arrival = 1; arrival <= kSlots; ++arrival) EXPECT_TRUE(put(feed_, arrival));
  bell_.wait(0);
  EXPECT_FALSE(put(feed_, 5));
  EXPECT_FALSE(put(feed_, 6));
  EXPECT_FALSE(bell_.wait(0)) << "rung for nothing";
  EXPECT_EQ(feed_.counters().frames_fed.value(), kSlots);
  EXPECT_EQ(feed_.counters().frames_not_fed.value(), 2U);
  expect_next(1);
  EXPECT_TRUE(put(feed_, 7));
  for (const std::uint64_t arrival : {2, 3, 4, 7}) expect_next(arrival);
  EXPECT_EQ(feed_.front(), nullptr);
}

TEST_F(FrameFeedTest, TheFrameInFrontStaysUntilItIsPopped) {
  put(feed_, 1);
  const FedFrame* const held = feed_.front();
  for (std::uint64_t arrival = 2; arrival <= 3 * kSlots; ++arrival) put(feed_, arrival);
  EXPECT_EQ(feed_.front(), held);
  expect_next(1);
  expect_next(2);
}

TEST_F(FrameFeedTest, AFrameThatIsTooLargeIsNotFed) {
  FanGeometry larger = geometry_of(0);
  ++larger.columns;
  const std::vector<std::uint8_t> pixels(larger.frame_bytes());
  EXPECT_FALSE(feed_.put({.arrival = 1}, larger, pixels));
  EXPECT_EQ(feed_.front(), nullptr);
  EXPECT_FALSE(bell_.wait(0));
  EXPECT_EQ(feed_.counters().frames_not_fed.value(), 1U);
  EXPECT_TRUE(put(feed_, 5)) << "the largest that fits";
  expect_next(5);
}

TEST_F(FrameFeedTest, UsesTheSameMemoryAgainAndAgain) {
  std::set<const std::uint8_t*> places;
  for (std::uint64_t arrival = 1; arrival <= 10 * kSlots; ++arrival) {
    EXPECT_TRUE(put(feed_, arrival));
    ASSERT_NE(feed_.front(), nullptr);
    places.insert(feed_.front()->pixels.data());
    expect_next(arrival);
  }
  EXPECT_EQ(places.size(), kSlots);
  EXPECT_EQ(*places.rbegin() - *places.begin(), (kSlots - 1) * kMostColumns * kRows) << "not one block";
}

// Run under the thread sanitizer. The reader begins when the feed is full, so that frames are refused; every
// tenth frame, the last one too, is put until it is taken, so that frames are read to the end.
TEST_F(FrameFeedTest, TwoThreadsLoseOnlyWhatWasRefused) {
  constexpr std::uint64_t kFrames = 100'000;
  std::vector<std::uint64_t> taken;
  std::uint64_t refusals = 0;
  std::atomic<bool> refused = false;
  std::jthread writer([&](const std::stop_token& stop) {
    for (std::uint64_t arrival = 1; arrival <= kFrames; ++arrival) {
      while (true) {
        if (put(feed_, arrival)) {
          taken.push_back(arrival);
          break;
        }
        ++refusals;
        refused = true;
        refused.notify_one();
        if (arrival % 10 != 0 || stop.stop_requested()) break;
        std::this_thread::yield();
      }
    }
  });
  refused.wait(false);
  std::vector<std::uint64_t> read;
  while (read.empty() || read.back() < kFrames) {
    bell_.wait(-1);
    while (const FedFrame* const frame = feed_.front()) {
      expect_whole(*frame);
      ASSERT_FALSE(HasFatalFailure());
      read.push_back(frame->stamp.arrival);
      feed_.pop();
    }
  }
  writer.join();
  EXPECT_EQ(read, taken);
  EXPECT_EQ(feed_.front(), nullptr);
  EXPECT_EQ(feed_.counters().frames_fed.value(), taken.size());
  EXPECT_EQ(feed_.counters().frames_not_fed.value(), refusals);
  EXPECT_GT(refusals, 0U);
}

}  // namespace
}  // namespace fanlight
