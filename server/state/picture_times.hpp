// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/model/picture.hpp"

namespace fanlight {

/// Counts of times in buckets, as Prometheus has them. The bounds are in seconds, three for
/// each power of ten.
class TimeHistogram {
 public:
  static constexpr std::array<double, 15> kBoundsS = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1,
                                                      0.25,   0.5,   1,      2.5,   5,    10,    30};

  void add(double seconds);
  /// How many were at most that bound, for each bound, and all in the last place.
  std::vector<std::uint64_t> cumulative() const;
  std::uint64_t count() const { return count_; }
  double sum_s() const { return sum_s_; }

 private:
  std::array<std::uint64_t, kBoundsS.size() + 1> counts_{};
  std::uint64_t count_ = 0;
  double sum_s_ = 0;
};

/// How long the stages of the main view's pictures took, and how old their volumes were. Server thread only.
class PictureTimes {
 public:
  void shown(const PictureStamp& stamp);

  const std::array<TimeHistogram, kStages>& stages() const { return stages_; }
  /// From the capture of a volume's last frame to its finished picture. Only the first picture of a volume
  /// counts: a moved light shows an old one.
  const TimeHistogram& ages() const { return ages_; }

 private:
  std::array<TimeHistogram, kStages> stages_;
  TimeHistogram ages_;
  std::uint64_t last_volume_ = 0;  // volumes count from 1
};

}  // namespace fanlight
