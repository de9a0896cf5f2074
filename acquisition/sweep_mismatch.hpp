#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "acquisition/sweep_thumbnails.hpp"
#include "proto/counter.hpp"
#include "proto/volume.hpp"

namespace fanlight {

/// Finds by how much forward and backward sweeps disagree, volume by volume, and takes it out of their
/// angles.
///
/// A motor with lag and backlash tells angles that trail behind: a forward frame is truly at its measured
/// angle plus d / 2, a backward one at minus d / 2 (only the difference d can be seen). Each sweep is
/// compared with the one before and the one after it (shift_between). What motion of the scene is left in
/// that has the other sign where forward and backward change their parts, so that two estimates in a row are
/// taken together. Of the last couples the median counts, less where they scatter: by 1 - (2 e / median)^2
/// with e the standard error that their median deviation gives, and not at all below 0. A tilt of the probe
/// is an outlier then, and a scene that moves too fast for the sweeps is left alone. All of them compare
/// measured angles, never the corrected ones, so the correction cannot feed on itself. What swings with just
/// half the rate of the volumes cannot be told from a mismatch.
///
/// Sweeps of one direction, after the first, cost nothing. Allocates in the constructor alone. One thread,
/// the acquisition thread.
class SweepMismatch {
 public:
  /// `counters` must outlive it.
  SweepMismatch(std::uint32_t frame_capacity, AcquisitionCounters& counters);

  /// Compares a finished, sorted volume with those before, and corrects its angles by what is known by now.
  /// `frames` holds its stamps in order of arrival.
  void correct(Volume& volume, std::span<const FrameStamp> frames);

  /// The next volume does not follow the last one: a probe was lost. What was found stays in force.
  void forget_volumes();

 private:
  static constexpr std::size_t kCompared = 3;
  static constexpr std::size_t kMostEstimates = 8;  // in a row
  static constexpr std::size_t kMostCouples = 24;
  struct Sweep {
    SweepThumbnails thumbnails;
    double corrected_rad = 0;  // mismatch taken out of the volume
  };
  struct Estimate {
    double mismatch_rad = 0;
    double left_rad = 0;  // of it, in the volumes compared as they were published
  };

  void compare(SweepDirection newest, const FanGeometry& geometry);
  double weighted(double Estimate::*value, std::size_t newest) const;
  double believed_rad() const;
  void report(const FanGeometry& geometry);

  AcquisitionCounters& counters_;
  std::array<Sweep, kCompared> sweeps_;  // the newest first
  std::size_t sweeps_in_a_row_ = 0;
  std::optional<SweepDirection> direction_;           // of the newest
  std::array<Estimate, kMostEstimates> estimates_{};  // the newest first
  std::size_t estimates_in_a_row_ = 0;
  std::array<double, kMostCouples> couples_rad_{};  // means of two estimates in a row, the newest first
  std::size_t couples_ = 0;
  double mismatch_rad_ = 0;  // in force
};

}  // namespace fanlight
