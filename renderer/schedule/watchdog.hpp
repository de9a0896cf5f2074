// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace fanlight {

/// Distinguishes a GPU that hangs from a slow one, by how long a submission is outstanding. Pure logic: time
/// is a parameter. One thread; no function blocks or allocates.
///
/// The limit follows from the longest of the last submissions: a machine that is busy with something else
/// makes all submissions slower, and the limit grows with them. Time counts only while the caller looks: a
/// process that was stopped, or starved by others, learns nothing about the GPU in the meantime.
class Watchdog {
 public:
  struct Limits {
    std::int64_t least_slow_ns = 2'000'000'000;   ///< a shorter submission is never slow
    std::int64_t least_hung_ns = 10'000'000'000;  ///< a shorter submission never hangs
    std::int64_t most_hung_ns = 120'000'000'000;  ///< a longer submission always hangs
  };
  /// A submission is slow, or hangs, after this multiple of the longest of the last ones.
  static constexpr std::int64_t kSlowTimes = 5;
  static constexpr std::int64_t kHungTimes = 20;
  /// Number of submissions that the longest one is of.
  static constexpr std::size_t kRecent = 64;
  /// Longest time between two calls of observe() that counts as waiting for the GPU.
  static constexpr std::int64_t kMostGapNs = 1'000'000'000;
  static constexpr std::size_t kMostLanes = 12;

  enum class Pace : std::uint8_t { kUsual, kSlow, kHung };

  /// Submissions of one timeline.
  struct Lane {
    std::uint64_t submissions = 0;  ///< so far
    bool outstanding = false;       ///< the newest one is not finished
  };

  Watchdog() = default;
  explicit Watchdog(const Limits& limits) : limits_(limits) {}

  /// The pace of the slowest lane. To be called often while something is outstanding. `lanes`: at most
  /// kMostLanes, always in the same order.
  Pace observe(std::span<const Lane> lanes, std::int64_t now_ns);

  std::int64_t slow_after_ns() const;
  std::int64_t hung_after_ns() const;

 private:
  struct Watched {
    std::uint64_t submission = 0;  // number of the submission that is waited for
    std::int64_t waited_ns = 0;
    bool outstanding = false;
  };
  void finished(std::int64_t took_ns);
  std::int64_t longest_ns() const;

  Limits limits_;
  std::array<Watched, kMostLanes> watched_{};
  std::array<std::int64_t, kRecent> took_ns_{};
  std::size_t next_ = 0;  // of took_ns_, to be overwritten next
  std::int64_t last_ns_ = 0;
};

}  // namespace fanlight
