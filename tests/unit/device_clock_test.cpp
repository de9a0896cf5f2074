// SPDX-License-Identifier: Apache-2.0
#include "acquisition/source/device_clock.hpp"

#include <gtest/gtest.h>

#include "tests/support/milliseconds.hpp"

namespace fanlight {
namespace {

constexpr std::int64_t kHostStartNs = 5'000'000 * kMs;

TEST(DeviceClock, FollowsTheFastestFrame) {
  DeviceClock clock;
  // Frames every 10 ms with transfer times of 3, 1 and 7 ms.
  EXPECT_EQ(clock.host_time_ns(0, kHostStartNs + 3 * kMs), kHostStartNs + 3 * kMs);
  EXPECT_EQ(clock.host_time_ns(10 * kMs, kHostStartNs + 11 * kMs), kHostStartNs + 11 * kMs);
  EXPECT_EQ(clock.host_time_ns(20 * kMs, kHostStartNs + 27 * kMs), kHostStartNs + 21 * kMs);
}

TEST(DeviceClock, FollowsAClockThatRunsSlow) {
  DeviceClock clock;
  // 100 parts per million: after 100 s the device is 10 ms behind. A transfer takes 1 ms.
  for (std::int64_t host = 0; host < 100'000 * kMs; host += 20 * kMs) {
    const std::int64_t device = host - host / 10'000;
    const std::int64_t host_time_ns =
        clock.host_time_ns(static_cast<std::uint64_t>(device), kHostStartNs + host + kMs);
    EXPECT_LE(host_time_ns, kHostStartNs + host + kMs) << "no frame arrives before it was taken";
    // The error is at most the drift over two windows.
    EXPECT_GE(host_time_ns, kHostStartNs + host + kMs - 2 * DeviceClock::kWindowNs / 10'000);
  }
}

TEST(DeviceClock, FollowsAClockThatRunsFast) {
  DeviceClock clock;
  for (std::int64_t host = 0; host < 100'000 * kMs; host += 20 * kMs) {
    const std::int64_t device = host + host / 10'000;
    const std::int64_t host_time_ns =
        clock.host_time_ns(static_cast<std::uint64_t>(device), kHostStartNs + host + kMs);
    EXPECT_EQ(host_time_ns, kHostStartNs + host + kMs);
  }
}

TEST(DeviceClock, FollowsAClockThatWasSetBack) {
  DeviceClock clock;
  constexpr std::int64_t kDay = 86'400'000 * kMs;
  EXPECT_EQ(clock.host_time_ns(kDay, kHostStartNs + kMs), kHostStartNs + kMs);
  // One such time is taken for an error: the frame has the time of its arrival.
  EXPECT_EQ(clock.host_time_ns(20 * kMs, kHostStartNs + 24 * kMs), kHostStartNs + 24 * kMs);
  EXPECT_EQ(clock.host_time_ns(kDay + 40 * kMs, kHostStartNs + 42 * kMs), kHostStartNs + 41 * kMs);
  // Two in a row: the clock was set.
  (void)clock.host_time_ns(60 * kMs, kHostStartNs + 62 * kMs);
  EXPECT_EQ(clock.host_time_ns(80 * kMs, kHostStartNs + 82 * kMs), kHostStartNs + 82 * kMs);
  EXPECT_EQ(clock.host_time_ns(100 * kMs, kHostStartNs + 109 * kMs), kHostStartNs + 102 * kMs);
}

TEST(DeviceClock, DoesNotTakeADelayForAClockThatWasSetBack) {
  DeviceClock clock;
  EXPECT_EQ(clock.host_time_ns(0, kHostStartNs), kHostStartNs);
  for (std::int64_t delay_ms = 1000; delay_ms < 15'000; delay_ms += 1000) {
    EXPECT_EQ(clock.host_time_ns(10 * kMs, kHostStartNs + 10 * kMs + delay_ms * kMs), kHostStartNs + 10 * kMs)
        << "a frame of " << delay_ms << " ms ago is not new";
  }
}

TEST(DeviceClock, TakesAnyNumber) {
  DeviceClock clock;
  (void)clock.host_time_ns(~0ULL, kHostStartNs);
  (void)clock.host_time_ns(1ULL << 63, kHostStartNs + 1);
  (void)clock.host_time_ns(0, kHostStartNs + 2);
  clock.reset();
  EXPECT_EQ(clock.host_time_ns(7, kHostStartNs + 3), kHostStartNs + 3);
}

}  // namespace
}  // namespace fanlight
