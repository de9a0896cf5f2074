// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/model/frame.hpp"

namespace fanlight {

/// Detects reversals of a sweeping motor from its angles. The angles may jitter, and the motor may pause at a
/// reversal. A reversal is detected when the angle has come back from its extreme by 1.2 frame distances
/// (mean distance of the last sweep), after a travel of at least twice that; a jitter of 0.6 distances to
/// either side is therefore no reversal. The threshold is at least 1 % of the motor's range (used while no
/// sweep is known) and at most a quarter of it (for sweeps of very few frames).
///
/// One thread. Allocates nothing.
class ReversalDetector {
 public:
  struct Range {
    double first_angle_rad = 0;  ///< smallest and largest angle of a sweep
    double last_angle_rad = 0;
  };

  explicit ReversalDetector(const Range& range);

  /// Takes the next frame's angle. True where it shows a reversal: the open sweep ended with the frame
  /// extreme_sequence(). The direction of the first sweep is unknown until the angle has moved; finding it is
  /// no reversal.
  bool reversed(std::uint64_t sequence, double angle_rad);

  /// First frame at the extreme of the last reversal.
  std::uint64_t extreme_sequence() const { return extreme_sequence_; }

  /// Direction of the open sweep.
  SweepDirection direction() const {
    return direction_sign_ < 0 ? SweepDirection::kBackward : SweepDirection::kForward;
  }

  /// Forgets the open sweep, but keeps the frame distance.
  void reset();

 private:
  struct Sample {
    std::uint64_t sequence = 0;
    double angle_rad = 0;
  };

  double least_return_rad() const;
  void find_direction();

  double range_rad_;
  double step_rad_ = 0;     // mean frame distance of the last sweep
  int direction_sign_ = 0;  // +1 or -1; 0 while the angle has not moved
  bool started_ = false;
  Sample start_;  // first frame; later the extreme at which the sweep began
  Sample lowest_;
  Sample highest_;
  std::uint64_t extreme_sequence_ = 0;
};

}  // namespace fanlight
