// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "acquisition/igtl/frame_notes.hpp"

namespace fanlight {

/// How long the sweeps are that the first images are of.
struct SweepLengths {
  bool counted = false;        ///< the images name their volume, and their place in it
  bool enough = false;         ///< a whole sweep was among them
  std::uint32_t longest = 0;   ///< frames of the longest one, of those seen
  std::uint32_t capacity = 0;  ///< that a volume should be able to hold
  double smallest_rad = 0;     ///< range of the angles
  double largest_rad = 0;
};

/// `angles_rad`: of each image; absent: not known. A sweep ends where the volume's index changes, or else
/// where the angle comes back by a tenth of its range so far, and by 0.2 deg.
SweepLengths sweep_lengths(std::span<const FrameNotes> images,
                           std::span<const std::optional<double>> angles_rad);

}  // namespace fanlight
