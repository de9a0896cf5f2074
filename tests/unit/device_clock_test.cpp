// SPDX-License-Identifier: Apache-2.0
#include "acquisition/source/device_clock.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/support/milliseconds.hpp"

namespace fanlight {
namespace {

constexpr std::int64_t kHostStartNs = 5'000'000 * kMs;

/// What the offset may have risen by in a time without a faster frame.
constexpr std::int64_t drift_of(std::int64_t passed_ns) {
  return passed_ns / 1'000'000 * DeviceClock::kMostDriftPpm;
}

void expect_near(std::int64_t time_ns, std::int64_t expected_ns, std::int64_t tolerance_ns,
                 const std::string& what = "") {
  EXPECT_LE(std::abs(time_ns - expected_ns), tolerance_ns) << what;
}

TEST(DeviceClock, FollowsTheFastestFrame) {
  DeviceClock clock;
  // Frames every 10 ms with transfer times of 3, 1 and 7 ms.
  EXPECT_EQ(clock.host_time_ns(0, kHostStartNs + 3 * kMs), kHostStartNs + 3 * kMs);
  EXPECT_EQ(clock.host_time_ns(10 * kMs, kHostStartNs + 11 * kMs), kHostStartNs + 11 * kMs);
  expect_near(clock.host_time_ns(20 * kMs, kHostStartNs + 27 * kMs), kHostStartNs + 21 * kMs,
              drift_of(16 * kMs));
}

TEST(DeviceClock, FollowsAClockThatRunsSlow) {
  DeviceClock clock;
  // 100 parts per million: after 100 s the device is 10 ms behind. A transfer takes 1 ms.
  for (std::int64_t host = 0; host < 100'000 * kMs; host += 20 * kMs) {
    const std::int64_t device = host - host / 10'000;
    const std::int64_t host_time_ns =
        clock.host_time_ns(static_cast<std::uint64_t>(device), kHostStartNs + host + kMs);
    EXPECT_LE(host_time_ns, kHostStartNs + host + kMs) << "no frame arrives before it was taken";
    EXPECT_GE(host_time_ns, kHostStartNs + host);
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
  expect_near(clock.host_time_ns(kDay + 40 * kMs, kHostStartNs + 42 * kMs), kHostStartNs + 41 * kMs,
              drift_of(41 * kMs));
  // Two in a row: the clock was set.
  (void)clock.host_time_ns(60 * kMs, kHostStartNs + 62 * kMs);
  EXPECT_EQ(clock.host_time_ns(80 * kMs, kHostStartNs + 82 * kMs), kHostStartNs + 82 * kMs);
  expect_near(clock.host_time_ns(100 * kMs, kHostStartNs + 109 * kMs), kHostStartNs + 102 * kMs,
              drift_of(27 * kMs));
}

TEST(DeviceClock, DoesNotTakeADelayForAClockThatWasSetBack) {
  DeviceClock clock;
  EXPECT_EQ(clock.host_time_ns(0, kHostStartNs), kHostStartNs);
  for (std::int64_t delay_ms = 1000; delay_ms < 15'000; delay_ms += 1000) {
    expect_near(clock.host_time_ns(10 * kMs, kHostStartNs + 10 * kMs + delay_ms * kMs),
                kHostStartNs + 10 * kMs, drift_of(15'000 * kMs),
                "a frame of " + std::to_string(delay_ms) + " ms ago is not new");
  }
}

TEST(DeviceClock, ADelayThatStaysIsNotForgotten) {
  DeviceClock clock;
  (void)clock.host_time_ns(0, kHostStartNs);
  // A relay holds the frames for 8 s, for five minutes.
  for (std::int64_t device = 0; device < 300'000 * kMs; device += 50 * kMs) {
    const std::int64_t arrival_ns = kHostStartNs + device + 8000 * kMs;
    const std::int64_t host_time_ns = clock.host_time_ns(static_cast<std::uint64_t>(device), arrival_ns);
    ASSERT_GE(arrival_ns - host_time_ns, 7800 * kMs) << "after " << device / (1000 * kMs) << " s";
  }
  // It holds them no more.
  const std::int64_t device = 301'000 * kMs;
  EXPECT_EQ(clock.host_time_ns(device, kHostStartNs + device), kHostStartNs + device);
}

TEST(DeviceClock, FollowsAClockThatWasSetForward) {
  DeviceClock clock;
  constexpr std::int64_t kHour = 3'600'000 * kMs;
  (void)clock.host_time_ns(0, kHostStartNs);
  EXPECT_EQ(clock.host_time_ns(kHour, kHostStartNs + 20 * kMs), kHostStartNs + 20 * kMs);
  EXPECT_EQ(clock.host_time_ns(kHour + 20 * kMs, kHostStartNs + 41 * kMs), kHostStartNs + 41 * kMs);
  expect_near(clock.host_time_ns(kHour + 40 * kMs, kHostStartNs + 70 * kMs), kHostStartNs + 61 * kMs,
              drift_of(29 * kMs));
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
