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
