#pragma once

#include <cstdint>

#include "proto/frame.hpp"

namespace fanlight {

/// Tells from the angles of a motor that sweeps to and fro where it turned. Angles may jitter and the motor
/// may stand where it turns: the angle has turned when it has come back from its extreme by 1.2 frame
/// distances (the mean one of the last sweep), after a way of twice that at least. So a jitter of 0.6
/// distances to either side is no turn. It is 1 % of the motor's range at least, while no sweep is known, and
/// a quarter of it at most, for sweeps of very few frames.
///
/// One thread. Allocates nothing.
class TurningFinder {
 public:
  struct Range {
    double first_angle_rad = 0;  ///< smallest and largest angle of a sweep
    double last_angle_rad = 0;
  };

  explicit TurningFinder(const Range& range);

  /// Takes the next frame's angle. True where it shows that the motor has turned: the sweep under way ended
  /// with the frame extreme_sequence(), and goes the other way after it. The first sweep's direction is
  /// unknown before it has come a bit of its way, and is not an event.
  bool turned(std::uint64_t sequence, double angle_rad);

  /// Of the last turn: the first frame at the outermost angle.
  std::uint64_t extreme_sequence() const { return extreme_sequence_; }

  /// Which way the sweep under way goes.
  SweepDirection direction() const { return way_ < 0 ? SweepDirection::kBackward : SweepDirection::kForward; }

  /// Forgets the sweep under way, not how far frames lie apart.
  void begin_anew();

 private:
  struct Look {
    std::uint64_t sequence = 0;
    double angle_rad = 0;
  };

  double least_return_rad() const;
  void find_way();

  double range_rad_;
  double step_rad_ = 0;  // mean distance of frames in the last sweep
  int way_ = 0;          // +1 or -1; 0 while nothing has moved
  bool begun_ = false;
  Look start_;  // the first frame; then the extreme that the sweep began at
  Look lowest_;
  Look highest_;
  std::uint64_t extreme_sequence_ = 0;
};

}  // namespace fanlight
