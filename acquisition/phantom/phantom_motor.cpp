// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/phantom_motor.hpp"

#include <cmath>
#include <cstdlib>

#include "acquisition/phantom/speckle_tile.hpp"

namespace fanlight {

namespace {

// Separate the random numbers of turning and jitter, and of other users of the same seed.
constexpr std::uint64_t kOfTurning = 0x7475'726e;
constexpr std::uint64_t kOfJitter = 0x6a69'7474;

/// Uniform in -1 to 1.
double even(std::uint64_t bits) {
  return std::ldexp(static_cast<double>(bits >> 11), -52) - 1;
}

}  // namespace

PhantomMotor::PhantomMotor(const Config& config) : config_(config), last_step_(end_of(0)) {}

PhantomMotor::Position PhantomMotor::at(std::uint64_t sequence) {
  while (sequence - first_sequence_ >= frames()) {
    first_sequence_ += frames();
    first_step_ = last_step_;
    last_step_ = end_of(++sweep_);
  }
  const auto in_sweep = static_cast<std::int64_t>(sequence - first_sequence_);
  const bool forward = sweep_ % 2 == 0;
  const auto place = static_cast<double>(first_step_ + (forward ? in_sweep : -in_sweep));
  const double share = place / (config_.frames_per_volume - 1);
  const double true_rad = std::lerp(-config_.sweep_rad / 2, config_.sweep_rad / 2, share);
  const double jitter = even(mixed_bits(config_.seed + mixed_bits(sequence + kOfJitter)));
  return {.sweep = sweep_,
          .frame_in_sweep = static_cast<std::uint32_t>(in_sweep),
          .direction = forward ? SweepDirection::kForward : SweepDirection::kBackward,
          .true_angle_rad = true_rad,
          .measured_angle_rad =
              true_rad + (forward ? -0.5 : 0.5) * config_.lag_rad + config_.jitter_rad * jitter};
}

double PhantomMotor::furthest_rad() const {
  return config_.sweep_rad / 2 + config_.turning_frames * step_rad() + std::abs(config_.lag_rad) / 2 +
         config_.jitter_rad;
}

std::int64_t PhantomMotor::end_of(std::uint64_t sweep) const {
  const std::int64_t in_time = sweep % 2 == 0 ? config_.frames_per_volume - 1 : 0;
  if (config_.turning_frames == 0) return in_time;
  const std::uint64_t bits = mixed_bits(config_.seed + mixed_bits(sweep + kOfTurning));
  return in_time + static_cast<std::int64_t>(bits % (2 * config_.turning_frames + 1)) -
         config_.turning_frames;
}

std::uint64_t PhantomMotor::frames() const {
  return static_cast<std::uint64_t>(std::abs(last_step_ - first_step_)) + 1;
}

}  // namespace fanlight
