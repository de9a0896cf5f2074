// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fanlight {

/// Checks the motor angles of a sweep against the sweep's own steps. A motor does not jump: where an angle
/// lies apart from its neighbours in time, and these agree with each other, it is wrong (an outlier). Where
/// the frames before and after a jump do not agree, part of the sweep is absent (a gap).
///
/// The usual step of a sweep is the mean of its steps from frame to frame without those above six times their
/// median, and no less than that median. Both count steps of a quarter of the mean at least: what is less is
/// a stand-still with noise. A jump is a step above kMostSteps usual steps for each sequence number that
/// passed; a jump that remains without the outliers is a gap if it is above kGapSteps. Fewer than
/// kFewestFrames frames are not judged.
///
/// The constructor allocates all memory. One thread.
class AngleCheck {
 public:
  /// A hand-tilted sweep has steps up to 2.5 times the usual one, a motor 1.6 (its speed is a sine).
  static constexpr double kMostSteps = 3;
  /// Three frames that were lost without a number leave four steps, a quarter more where a motor is fast.
  static constexpr double kGapSteps = 5;
  /// Outliers in succession. More are taken for a part of the sweep.
  static constexpr std::size_t kMostOutliersInARow = 3;
  static constexpr std::size_t kFewestFrames = 6;

  struct Frame {
    std::uint64_t sequence = 0;  ///< ascending
    double angle_rad = 0;
  };
  struct Findings {
    std::span<const std::size_t> outliers;  ///< indices of the frames, ascending; valid until the next call
    double usual_step_rad = 0;              ///< 0: not known
    double gap_rad = 0;                     ///< the largest jump that remains without the outliers; 0: none
  };

  explicit AngleCheck(std::size_t frame_capacity);

  /// `frames`: in order of sequence, at most the capacity.
  Findings check(std::span<const Frame> frames);

 private:
  bool jumps(const Frame& from, const Frame& to) const;
  double usual_step_rad(std::span<const Frame> frames);
  void cut_at_jumps(std::span<const Frame> frames);
  std::size_t longest_run() const;

  struct Run {
    std::size_t first = 0;
    std::size_t end = 0;
    bool kept = false;
  };
  double usual_rad_ = 0;
  std::vector<double> steps_rad_;
  std::vector<Run> runs_;  // between jumps
  std::vector<std::size_t> outliers_;
};

}  // namespace fanlight
