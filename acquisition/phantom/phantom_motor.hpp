// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/model/frame.hpp"

namespace fanlight {

/// Motor of the simulated probe: sweeps forward and backward, one angle step a frame, and pauses for one
/// frame at each reversal. Its measured angles can lag and jitter, and it can reverse early or late. Equal
/// seeds give equal motion. One thread; allocates nothing.
class PhantomMotor {
 public:
  struct Config {
    std::uint32_t frames_per_volume = 35;
    double sweep_rad = 0;   ///< whole range, half to either side
    double lag_rad = 0;     ///< measured angles trail by half of this: too small forward, too large backward
    double jitter_rad = 0;  ///< measured angles are wrong by up to this, to either side
    std::uint32_t turning_frames = 0;  ///< sweeps end up to this many frames early or late
    std::uint64_t seed = 1;
  };
  struct Position {
    std::uint64_t sweep = 0;
    std::uint32_t frame_in_sweep = 0;
    SweepDirection direction = SweepDirection::kForward;
    double true_angle_rad = 0;
    double measured_angle_rad = 0;
  };

  explicit PhantomMotor(const Config& config);

  /// Position at the frame `sequence`. Precondition: `sequence` never decreases between calls.
  Position at(std::uint64_t sequence);

  /// Angle between neighbouring frames.
  double step_rad() const { return config_.sweep_rad / (config_.frames_per_volume - 1); }
  /// Largest possible number of frames in a sweep.
  std::uint32_t most_frames() const { return config_.frames_per_volume + 2 * config_.turning_frames; }
  /// Largest absolute measured angle.
  double furthest_rad() const;

 private:
  std::int64_t end_of(std::uint64_t sweep) const;
  std::uint64_t frames() const;

  Config config_;
  // The open sweep. Positions count the angle steps from the first angle of a sweep that reversed on time.
  std::uint64_t sweep_ = 0;
  std::uint64_t first_sequence_ = 0;
  std::int64_t first_step_ = 0;
  std::int64_t last_step_;
};

}  // namespace fanlight
