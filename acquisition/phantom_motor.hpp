#pragma once

#include <cstdint>

#include "proto/frame.hpp"

namespace fanlight {

/// The motor of the simulated probe: sweeps to and fro, one step of the angle a frame, and stands for one
/// frame where it turns. What it measures can lag and jitter, and it can turn early or late. Equal seeds give
/// equal motors. One thread; allocates nothing.
class PhantomMotor {
 public:
  struct Config {
    std::uint32_t frames_per_volume = 35;
    double sweep_rad = 0;   ///< the whole of it, half to either side
    double lag_rad = 0;     ///< measured angles trail by half of it: forward too small, backward too large
    double jitter_rad = 0;  ///< measured angles are wrong by up to this much, to either side
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

  /// At the frame of that number. Precondition: the numbers asked for never fall.
  Position at(std::uint64_t sequence);

  /// The most frames that a sweep can have.
  std::uint32_t most_frames() const { return config_.frames_per_volume + 2 * config_.turning_frames; }
  /// No measured angle is further from the middle.
  double furthest_rad() const;

 private:
  double step_rad() const { return config_.sweep_rad / (config_.frames_per_volume - 1); }
  std::int64_t end_of(std::uint64_t sweep) const;
  std::uint64_t frames() const;

  Config config_;
  // The sweep under way; places count the steps from the first angle of a sweep that turned in time.
  std::uint64_t sweep_ = 0;
  std::uint64_t first_sequence_ = 0;
  std::int64_t first_place_ = 0;
  std::int64_t last_place_;
};

}  // namespace fanlight
