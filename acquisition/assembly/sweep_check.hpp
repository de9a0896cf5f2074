// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "acquisition/assembly/ring_check.hpp"
#include "acquisition/assembly/sweep_thumbnails.hpp"
#include "proto/model/sweep_warnings.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// Compares the frames of a sweep with each other, and with those of the sweep before: tells what no stamp
/// tells. All comparisons are of thumbnails, which average most of the speckle, or end at the first pixel
/// that differs; a sweep without faults costs some 1 ms. Allocates in the constructor only. One thread, the
/// acquisition thread.
class SweepCheck {
 public:
  explicit SweepCheck(std::uint32_t frame_capacity);

  /// What looks wrong in a finished, sorted volume of two frames or more. `thumbnails`: of that volume.
  SweepWarnings check(const Volume& volume, const SweepThumbnails& thumbnails);

  /// The next volume does not continue the last one.
  void forget_volumes() {
    before_.clear();
    was_mirrored_ = false;
  }

 private:
  bool jumps(const SweepThumbnails& sweep);

  SweepThumbnails before_;
  bool was_mirrored_ = false;
  RingCheck rings_;
  std::vector<float> steps_;  // squared differences of neighbours
};

}  // namespace fanlight
