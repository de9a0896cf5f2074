// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace fanlight {

/// What a volume on a grid has around the echoes: a fan that was scan converted fills its grid to a part
/// only.
struct GridPadding {
  enum class Look : std::uint8_t {
    kNone,    ///< less than 2 % of the volume
    kBorder,  ///< as of a fan: it fills all corners of the grid, and what it leaves reaches all sides and has
              ///< hardly any dents
    kFluid,   ///< part of it looks like fluid without an echo: it cannot be told from what was not scanned
  };
  Look look = Look::kNone;
  double share = 0;  ///< of the volume
  /// For each voxel 1 where it has the padding's value and is connected to the border of the grid by such
  /// voxels, else 0.
  std::vector<std::uint8_t> voxels;
};

/// `is_value`: for each voxel of size[0] x size[1] x size[2], the first axis fastest, 1 where it has the
/// value that is taken for the padding's, else 0. Memory as that of `is_value`.
///
/// Measured: the real grids of REAL_FILES.md and phantoms, padded or in fluid without an echo
/// (tests/formats/grid_padding_test.cpp).
GridPadding find_padding(std::array<std::uint32_t, 3> size, std::vector<std::uint8_t> is_value);

}  // namespace fanlight
