// SPDX-License-Identifier: Apache-2.0
// The threads that encode; also run under the thread sanitizer.
#include "server/codec/encoder_pool.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

namespace fanlight::test {
namespace {

TEST(EncoderPool, RunsAllWorkOfBothLanes) {
  constexpr int kWorks = 200;
  std::latch all(2 * kWorks);
  std::atomic<int> quick = 0;
  std::atomic<int> heavy = 0;
  EncoderPool pool(2);
  EXPECT_EQ(pool.threads(), 2U);
  for (int work = 0; work < kWorks; ++work) {
    pool.submit(EncoderLane::kQuick, [&] { ++quick, all.count_down(); });
    pool.submit(EncoderLane::kHeavy, [&] { ++heavy, all.count_down(); });
  }
  all.wait();
  EXPECT_EQ(quick, kWorks);
  EXPECT_EQ(heavy, kWorks);
}

TEST(EncoderPool, AHeavyWorkDoesNotHoldUpAQuickOne) {
  std::latch quick_ran(1);
  std::latch heavy_ran(1);
  EncoderPool pool(1);
  pool.submit(EncoderLane::kHeavy, [&] {
    quick_ran.wait();  // for ever, if the quick one waited for this one
    heavy_ran.count_down();
  });
  pool.submit(EncoderLane::kQuick, [&] { quick_ran.count_down(); });
  heavy_ran.wait();
}

TEST(EncoderPool, ItsEndDropsTheWorkThatWaits) {
  std::latch begun(1);
  std::latch may_end(1);
  std::atomic<int> ran = 0;
  {
    EncoderPool pool(1);
    pool.submit(EncoderLane::kQuick, [&] {
      begun.count_down();
      may_end.wait();
      ++ran;
    });
    begun.wait();
    pool.submit(EncoderLane::kQuick, [&] { ++ran; });
    // The destructor has asked the threads to stop before the first work ends, or the second one runs: both
    // are right, and a work is never cut short.
    may_end.count_down();
  }
  EXPECT_GE(ran, 1);
}

}  // namespace
}  // namespace fanlight::test
