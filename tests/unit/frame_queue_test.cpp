// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/frame_queue.hpp"

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

/// Frames differ in size. Neighbours, and frames that share a slot, differ in every pixel.
FanGeometry geometry_of(std::uint64_t commit_number) {
  return {.columns = kMostColumns - static_cast<std::uint32_t>(commit_number % 5),
          .rows = kRows,
          .pixel_width_mm = 1,
          .pixel_height_mm = 1,
          .motor_radius_mm = 30};
}

std::uint8_t pixel_of(std::uint64_t commit_number, std::uint64_t index) {
  return static_cast<std::uint8_t>(7 * commit_number + (commit_number >> 8) + 3 * index);
}

double angle_of(std::uint64_t commit_number) {
  return 0.001 * static_cast<double>(commit_number);
}

/// False where the queue did not take it.
bool put(FrameQueue& queue, std::uint64_t commit_number) {
  const FanGeometry geometry = geometry_of(commit_number);
  std::vector<std::uint8_t> pixels(geometry.frame_bytes());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = pixel_of(commit_number, i);
  return queue.put({.sequence = 1000 + commit_number,
                    .angle_rad = angle_of(commit_number),
                    .commit_number = commit_number},
                   geometry, pixels);
}

void expect_whole(const QueuedFrame& frame) {
  const std::uint64_t commit_number = frame.stamp.commit_number;
  ASSERT_EQ(frame.stamp.sequence, 1000 + commit_number);
  ASSERT_EQ(frame.stamp.angle_rad, angle_of(commit_number));
  ASSERT_EQ(frame.geometry, geometry_of(commit_number));
  ASSERT_EQ(frame.pixels.size(), frame.geometry.frame_bytes());
  for (std::size_t i = 0; i < frame.pixels.size(); ++i) {
    ASSERT_EQ(frame.pixels[i], pixel_of(commit_number, i)) << "a torn frame";
  }
}

class FrameQueueTest : public testing::Test {
 protected:
  void expect_next(std::uint64_t commit_number) {
    const QueuedFrame* const frame = queue_.front();
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->stamp.commit_number, commit_number);
    expect_whole(*frame);
    queue_.pop();
  }

  Doorbell bell_;
  FrameQueue queue_{{.largest_frame_bytes = kMostColumns * kRows, .slots = kSlots}, {.reader_bell = bell_}};
};

TEST_F(FrameQueueTest, IsEmptyAtFirst) {
  EXPECT_EQ(queue_.front(), nullptr);
  EXPECT_FALSE(bell_.wait(0));
}

TEST_F(FrameQueueTest, GivesFramesInOrderAndRingsTheBell) {
  EXPECT_TRUE(put(queue_, 1));
  EXPECT_TRUE(bell_.wait(0));
  EXPECT_TRUE(put(queue_, 2));
  EXPECT_TRUE(bell_.wait(0));
  EXPECT_TRUE(put(queue_, 3));
  expect_next(1);
  expect_next(2);
  expect_next(3);
  EXPECT_EQ(queue_.front(), nullptr);
  EXPECT_EQ(queue_.counters().frames_fed.value(), 3U);
  EXPECT_EQ(queue_.counters().frames_not_fed.value(), 0U);
}

TEST_F(FrameQueueTest, AFullFeedKeepsWhatItHasAndCountsTheRest) {
  for (std::uint64_t commit_number = 1; commit_number <= kSlots; ++commit_number)
    EXPECT_TRUE(put(queue_, commit_number));
  bell_.wait(0);
  EXPECT_FALSE(put(queue_, 5));
  EXPECT_FALSE(put(queue_, 6));
  EXPECT_FALSE(bell_.wait(0)) << "rung for nothing";
  EXPECT_EQ(queue_.counters().frames_fed.value(), kSlots);
  EXPECT_EQ(queue_.counters().frames_not_fed.value(), 2U);
  expect_next(1);
  EXPECT_TRUE(put(queue_, 7));
  for (const std::uint64_t commit_number : {2, 3, 4, 7}) expect_next(commit_number);
  EXPECT_EQ(queue_.front(), nullptr);
}

TEST_F(FrameQueueTest, TheFrameInFrontStaysUntilItIsPopped) {
  put(queue_, 1);
  const QueuedFrame* const held = queue_.front();
  for (std::uint64_t commit_number = 2; commit_number <= 3 * kSlots; ++commit_number)
    put(queue_, commit_number);
  EXPECT_EQ(queue_.front(), held);
  expect_next(1);
  expect_next(2);
}

TEST_F(FrameQueueTest, AFrameThatIsTooLargeIsNotFed) {
  FanGeometry larger = geometry_of(0);
  ++larger.columns;
  const std::vector<std::uint8_t> pixels(larger.frame_bytes());
  EXPECT_FALSE(queue_.put({.commit_number = 1}, larger, pixels));
  EXPECT_EQ(queue_.front(), nullptr);
  EXPECT_FALSE(bell_.wait(0));
  EXPECT_EQ(queue_.counters().frames_not_fed.value(), 1U);
  EXPECT_TRUE(put(queue_, 5)) << "the largest that fits";
  expect_next(5);
}

// A queue that holds `waiting` frames at most uses the memory of so many, again and again.
TEST_F(FrameQueueTest, UsesTheMemoryOfTheFramesThatWait) {
  std::uint64_t commit_number = 0;
  for (std::uint64_t waiting = 1; waiting <= kSlots; ++waiting) {
    std::set<const std::uint8_t*> places;
    for (int round = 0; round < 10; ++round) {
      for (std::uint64_t i = 1; i <= waiting; ++i) EXPECT_TRUE(put(queue_, commit_number + i));
      for (std::uint64_t i = 1; i <= waiting; ++i) {
        ASSERT_NE(queue_.front(), nullptr);
        places.insert(queue_.front()->pixels.data());
        expect_next(commit_number + i);
      }
      commit_number += waiting;
    }
    EXPECT_EQ(places.size(), waiting);
    EXPECT_EQ(*places.rbegin() - *places.begin(), (waiting - 1) * kMostColumns * kRows) << "not one block";
  }
}

// Faults take a place in the queue, but no memory. The queue runs empty after different numbers of frames and
// faults, and holds some for ten rounds then.
TEST_F(FrameQueueTest, FramesThatWaitNeverShareMemory) {
  std::uint64_t put_last = 0;
  std::uint64_t read_last = 0;
  const auto put_next = [&] {
    ++put_last;
    return put_last % 3 == 0
               ? queue_.put_fault({.commit_number = put_last}, geometry_of(put_last), FrameFault::kMisfit)
               : put(queue_, put_last);
  };
  const auto read_next = [&] {
    const QueuedFrame* const frame = queue_.front();
    ASSERT_NE(frame, nullptr);
    ASSERT_EQ(frame->stamp.commit_number, ++read_last);
    if (frame->fault == FrameFault::kNone) expect_whole(*frame);
    queue_.pop();
  };
  for (std::uint64_t before = 0; before <= 2 * kSlots; ++before) {
    for (std::uint64_t i = 0; i < before; ++i) {
      ASSERT_TRUE(put_next());
      read_next();
    }
    for (int round = 0; round < 10; ++round) {
      while (put_last - read_last < kSlots) ASSERT_TRUE(put_next());
      EXPECT_TRUE(queue_.is_full());
      while (put_last - read_last > 1) read_next();
      ASSERT_FALSE(HasFatalFailure());
    }
    read_next();
  }
}

// The memory of reserve() is free again where its frame does not come.
TEST_F(FrameQueueTest, AFaultTakesThePlaceOfAFrameThatWasReserved) {
  ASSERT_TRUE(put(queue_, 1));
  ASSERT_FALSE(queue_.reserve(kRows * kMostColumns).empty());
  ASSERT_TRUE(queue_.put_fault({.commit_number = 2}, geometry_of(2), FrameFault::kCut));
  ASSERT_TRUE(put(queue_, 3));
  expect_next(1);
  ASSERT_NE(queue_.front(), nullptr);
  EXPECT_EQ(queue_.front()->fault, FrameFault::kCut);
  queue_.pop();
  expect_next(3);
}

// Run with the thread sanitizer. The reader starts when the queue is full, so that frames are refused. Every
// tenth frame, and the last one, is put again until it is taken, so that the reader runs to the end.
TEST_F(FrameQueueTest, TwoThreadsLoseOnlyWhatWasRefused) {
  constexpr std::uint64_t kFrames = 100'000;
  std::vector<std::uint64_t> taken;
  std::uint64_t refusals = 0;
  std::atomic<bool> refused = false;
  std::jthread writer([&](const std::stop_token& stop) {
    for (std::uint64_t commit_number = 1; commit_number <= kFrames; ++commit_number) {
      while (true) {
        if (put(queue_, commit_number)) {
          taken.push_back(commit_number);
          break;
        }
        ++refusals;
        refused = true;
        refused.notify_one();
        if (commit_number % 10 != 0 || stop.stop_requested()) break;
        std::this_thread::yield();
      }
    }
  });
  refused.wait(false);
  std::vector<std::uint64_t> read;
  while (read.empty() || read.back() < kFrames) {
    bell_.wait(-1);
    while (const QueuedFrame* const frame = queue_.front()) {
      expect_whole(*frame);
      ASSERT_FALSE(HasFatalFailure());
      read.push_back(frame->stamp.commit_number);
      queue_.pop();
    }
  }
  writer.join();
  EXPECT_EQ(read, taken);
  EXPECT_EQ(queue_.front(), nullptr);
  EXPECT_EQ(queue_.counters().frames_fed.value(), taken.size());
  EXPECT_EQ(queue_.counters().frames_not_fed.value(), refusals);
  EXPECT_GT(refusals, 0U);
}

}  // namespace
}  // namespace fanlight
