// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// A box of cubic cells in the transducer frame: cell (i, j, k) has its centre at `first` + step_mm * (i, j,
/// k), i along x, j along y, k along z. Values of cells are stored with k slowest, i fastest.
struct CellBox {
  Point first;
  double step_mm = 1;
  std::array<std::uint32_t, 3> size{};

  std::size_t cells() const { return std::size_t{size[0]} * size[1] * size[2]; }
  std::size_t index(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return (std::size_t{k} * size[1] + j) * size[0] + i;
  }
  Point centre(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return {first.x_mm + step_mm * i, first.y_mm + step_mm * j, first.z_mm + step_mm * k};
  }
  /// Whether all 26 neighbours of the cell are in the box.
  bool is_inner(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return i > 0 && j > 0 && k > 0 && i + 1 < size[0] && j + 1 < size[1] && k + 1 < size[2];
  }
};

/// The box of cells around a point that reaches `reach_mm` to each side of it.
CellBox box_around(const Point& middle, double reach_mm, double step_mm);

/// The echo of a volume at the centres of a box's cells.
struct EchoGrid {
  CellBox box;
  std::vector<float> levels;          ///< grey levels
  std::vector<std::uint8_t> scanned;  ///< of each cell: 1, or 0 where nothing was scanned

  /// Between eight centres; `at` in cells, 0 to size - 1.
  double level(double i, double j, double k) const;
};

/// Samples the volume, which has two frames or more. Errors: std::bad_alloc. Any thread.
EchoGrid sampled(const Volume& volume, const CellBox& box);

/// Replaces each level by the mean of 3 x 3 x 3 cells; at the sides of the box by that of fewer.
void smooth(EchoGrid& grid);

}  // namespace fanlight
