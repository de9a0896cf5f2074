// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// A volume on a Cartesian grid in the transducer frame: voxel (i, j, k) lies at origin_mm + spacing_mm *
/// (i, j, k), i lateral (x), j into the body (y), k in elevation (z).
struct GridVolume {
  std::array<double, 3> origin_mm{};  ///< centre of the first voxel
  double spacing_mm = 1;
  std::array<std::uint32_t, 3> size{};
  std::vector<std::uint8_t>
      voxels;  ///< grey levels, k slowest, i fastest; 0 where nothing was scanned, else 1 or more;
               ///< of Cartesian frames without a known sector, 0 may be either

  std::uint64_t bytes() const { return std::uint64_t{size[0]} * size[1] * size[2]; }
};

inline constexpr std::uint64_t kMostVoxels = std::uint64_t{1} << 32;

/// Told after each slice: the share that is done, 0 to 1. False ends the work.
using Progress = std::function<bool(double share)>;

/// The spacing that divides the longest side of the fan into about 256 voxels, in steps of 0.05 mm.
double usual_spacing_mm(const Volume& volume);

/// Scan conversion: each voxel is interpolated linearly between the two frames around its angle, and
/// bilinearly in each. No voxel lies beyond the outermost frames. Errors: kInvalidArgument for a spacing
/// under 0.01 mm or a grid of over 4096 voxels a side or `most_voxels` in all; kUnavailable: no memory;
/// kStopped by `progress`.
Result<GridVolume> scan_converted(const Volume& volume, double spacing_mm, const Progress& progress,
                                  std::uint64_t most_voxels = kMostVoxels);

}  // namespace fanlight
