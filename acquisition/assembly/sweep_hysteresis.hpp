// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "acquisition/assembly/sweep_thumbnails.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// Estimates the mismatch of forward and backward sweeps, volume by volume, and corrects the angles for it.
///
/// A motor with lag and backlash reports angles that trail behind: the true angle of a forward frame is its
/// measured angle plus d / 2, of a backward frame minus d / 2. Only the difference d can be observed. Each
/// sweep is compared with the one before and the one after it (shift_between). What remains of scene motion
/// in an estimate has the opposite sign in the next one, because forward and backward change places;
/// therefore the mean of two successive estimates (a pair) is used. The mismatch is the median of the last
/// pairs, times 1 - (2 e / median)^2, where e is the standard error from their median deviation, and 0 where
/// that factor is negative. A tilt of the probe is then an outlier, and a scene that moves too fast for the
/// sweeps is left uncorrected. All comparisons use measured angles, never corrected ones, so that the
/// correction does not feed back. Motion at exactly half the volume rate cannot be distinguished from a
/// mismatch.
///
/// Sweeps in one direction only are not compared. Allocates in the constructor only. One
/// thread, the acquisition thread.
class SweepHysteresis {
 public:
  /// `counters` must outlive it.
  SweepHysteresis(std::uint32_t frame_capacity, AcquisitionCounters& counters);

  /// Compares a finished, sorted volume with the ones before, and corrects its angles by the present
  /// estimate. `thumbnails`: of its frames, with the measured angles.
  void correct(Volume& volume, const SweepThumbnails& thumbnails);

  /// The next volume does not continue the last one: the probe was lost. The estimate stays in force.
  void forget_volumes();

 private:
  static constexpr std::size_t kCompared = 3;
  static constexpr std::size_t kMostEstimates = 8;  // successive ones
  static constexpr std::size_t kMostPairs = 24;
  struct Sweep {
    SweepThumbnails thumbnails;
    double corrected_rad = 0;  // mismatch by which this volume was corrected
  };
  struct Estimate {
    double mismatch_rad = 0;
    double remaining_rad = 0;  // mismatch that remained in the volumes as published
  };

  void compare(SweepDirection newest, const FanGeometry& geometry);
  double weighted(double Estimate::*value, std::size_t newest) const;
  double estimated_rad() const;
  void report(const FanGeometry& geometry);

  AcquisitionCounters& counters_;
  std::array<Sweep, kCompared> sweeps_;  // newest first
  std::size_t alternating_sweeps_ = 0;
  std::optional<SweepDirection> direction_;           // of the newest sweep
  std::array<Estimate, kMostEstimates> estimates_{};  // newest first
  std::size_t successive_estimates_ = 0;
  std::array<double, kMostPairs> pairs_rad_{};  // means of two successive estimates, newest first
  std::size_t pairs_ = 0;
  double mismatch_rad_ = 0;  // in force
};

}  // namespace fanlight
