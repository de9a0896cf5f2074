// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

namespace fanlight {

/// A sweep that the assembler gave no volume for.
struct DroppedSweep {
  enum class Reason : std::uint8_t {
    kMissing,  ///< too many frames are missing
    kRun,      ///< too many in a row
    kGap,      ///< the angle jumps between two frames
    kCutOff,   ///< it began or ended in its middle
    kStill,    ///< the angle did not move
  };
  std::uint64_t volume_index = 0;  ///< the source's own number
  Reason reason = Reason::kMissing;
  std::uint32_t frames = 0;   ///< usable ones
  std::uint64_t missing = 0;  ///< never received, or not usable
  std::uint64_t longest_run = 0;
  double gap_deg = 0;
  double usual_step_deg = 0;
};

/// Why it was dropped: "30 of 74 frames are missing, expected 15 % at most".
std::string reason_of(const DroppedSweep& sweep);

/// Dropped sweeps on their way from the acquisition thread (the only writer) to one reader. Beyond the
/// capacity further ones are forgotten. Never allocates, locks or blocks.
class DroppedSweeps {
 public:
  /// Writer.
  void put(const DroppedSweep& sweep) {
    const std::uint64_t put = put_.load(std::memory_order_relaxed);
    if (put - taken_.load(std::memory_order_acquire) == sweeps_.size()) return;
    sweeps_[put % sweeps_.size()] = sweep;
    put_.store(put + 1, std::memory_order_release);
  }
  /// Reader: the oldest; nullopt: none.
  std::optional<DroppedSweep> take() {
    const std::uint64_t taken = taken_.load(std::memory_order_relaxed);
    if (taken == put_.load(std::memory_order_acquire)) return std::nullopt;
    const DroppedSweep sweep = sweeps_[taken % sweeps_.size()];
    taken_.store(taken + 1, std::memory_order_release);
    return sweep;
  }

 private:
  std::array<DroppedSweep, 256> sweeps_{};
  std::atomic<std::uint64_t> put_{0};
  std::atomic<std::uint64_t> taken_{0};
};

}  // namespace fanlight
