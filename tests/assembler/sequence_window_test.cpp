// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/sequence_window.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace fanlight {
namespace {

using Arrival = SequenceWindow::Arrival;
using Frame = SequenceWindow::Frame;

struct Window {
  Arrival take(std::uint64_t sequence, Frame frame = Frame::kUsable) {
    const Arrival arrival = window.judge(sequence);
    if (arrival == Arrival::kNewest || arrival == Arrival::kReordered) window.mark(sequence, frame, gaps);
    return arrival;
  }
  SequenceWindow window;
  SequenceGaps gaps;
};

TEST(SequenceWindow, TellsNewFromRepeatedReorderedAndLate) {
  Window window;
  EXPECT_EQ(window.take(0), Arrival::kNewest);
  EXPECT_EQ(window.take(3), Arrival::kNewest);
  EXPECT_EQ(window.take(3), Arrival::kRepeated);
  EXPECT_EQ(window.take(0), Arrival::kRepeated);
  EXPECT_EQ(window.take(1), Arrival::kReordered);
  EXPECT_EQ(window.take(1), Arrival::kRepeated);
  window.window.settle_below(3, window.gaps);
  EXPECT_EQ(window.gaps.never_arrived, 1U);
  EXPECT_EQ(window.take(2), Arrival::kLate);
  EXPECT_EQ(window.take(1), Arrival::kRepeated);
}

TEST(SequenceWindow, ANumberStaysOpenUntilTheNewestIs64Ahead) {
  Window window;
  window.take(0);
  window.take(64);
  EXPECT_EQ(window.gaps.never_arrived, 0U);
  EXPECT_EQ(window.take(1), Arrival::kReordered);
  window.take(66);
  EXPECT_EQ(window.gaps.never_arrived, 1U) << "2";
  EXPECT_EQ(window.take(2), Arrival::kLate);
  EXPECT_EQ(window.take(3), Arrival::kReordered) << "3 stands at the edge";
}

TEST(SequenceWindow, CountsTheLongestGapAcrossTheWindow) {
  Window window;
  window.take(0);
  window.take(1, Frame::kUseless);
  window.take(1000);
  window.take(1002);
  window.window.settle_below(1003, window.gaps);
  EXPECT_EQ(window.gaps.never_arrived, 998U + 1);
  EXPECT_EQ(window.gaps.without_frame, 999U + 1);
  EXPECT_EQ(window.gaps.longest, 999U);
  EXPECT_EQ(window.gaps.present_run, 0U);
}

TEST(SequenceWindow, AJumpOfMoreThanAMillionIsARestart) {
  Window window;
  window.take(5'000'000 - 4'000'000);
  EXPECT_EQ(window.take(3'000'000), Arrival::kRestart);
  EXPECT_EQ(window.take(2'000'001), Arrival::kNewest) << "a million lost";
  EXPECT_EQ(window.take(1'000'000), Arrival::kRestart);
  window.window.begin_at(7);
  window.gaps = {};
  EXPECT_EQ(window.take(7), Arrival::kNewest);
  EXPECT_EQ(window.take(6), Arrival::kLate);
  window.window.settle_below(8, window.gaps);
  EXPECT_EQ(window.gaps.never_arrived, 0U);
}

TEST(SequenceWindow, TwoSuccessiveNumbersFarBehindAreARestart) {
  Window window;
  window.take(500);
  EXPECT_EQ(window.take(400), Arrival::kLate);
  EXPECT_EQ(window.take(402), Arrival::kLate);
  EXPECT_EQ(window.take(501), Arrival::kNewest);
  EXPECT_EQ(window.take(403), Arrival::kLate) << "not right after 402";
  EXPECT_EQ(window.take(404), Arrival::kRestart);
}

// Comparison with a plain set of all numbers.
TEST(SequenceWindow, NeverCountsWhatCame) {
  std::mt19937 random(3);
  Window window;
  std::set<std::uint64_t> came;
  std::uint64_t base = 0;
  for (int i = 0; i < 20'000; ++i) {
    base += random() % 100 == 0 ? random() % 200 : random() % 2;
    const std::uint64_t sequence = base + random() % 12;
    const Arrival arrival = window.take(sequence);
    ASSERT_NE(arrival, Arrival::kRestart);
    if (arrival == Arrival::kRepeated) {
      ASSERT_TRUE(came.contains(sequence));
    } else if (arrival != Arrival::kLate) {
      ASSERT_TRUE(came.insert(sequence).second);
    }
  }
  window.window.settle_below(window.window.next(), window.gaps);
  EXPECT_EQ(window.gaps.never_arrived + came.size(), window.window.next());
}

}  // namespace
}  // namespace fanlight
