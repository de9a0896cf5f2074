// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "proto/model/cut_list.hpp"
#include "shaders/cast_parameters.h"

namespace fanlight {

/// A box in the transducer frame, mm.
struct Box {
  glm::dvec3 lowest;
  glm::dvec3 highest;
};

/// A grid of cubes. Corners are numbered by x, then y, then z; corner (x, y, z) lies at lowest + cell_mm (x,
/// y, z).
struct CutGrid {
  static constexpr std::uint32_t kMostCells = 96;  ///< along an axis

  glm::dvec3 lowest{};
  double cell_mm = 0;
  glm::uvec3 cells{};

  /// The grid around a box. Cells are never smaller than 0.5 mm.
  static CutGrid around(const Box& box);
  bool operator==(const CutGrid&) const = default;
  std::size_t count() const { return std::size_t{cells.x} * cells.y * cells.z; }
};

/// What a CutList leaves of a volume, for pass 1: which corners of a grid are cut. Between them the cut ends
/// where the trilinear interpolation is 0.5 (renderer/ALGORITHM.md, pass 1).
class CutMask {
 public:
  /// Brings the mask up to date; whether it has changed. Further cuts and balls of the same list are added, a
  /// lasso in about 3 ms; else all are made again. Allocates with the first cut, and for a larger grid.
  bool update(const CutList& list, const CutGrid& grid);

  const CutGrid& grid() const { return grid_; }

  /// Writes a byte for each cell, in the order of corners: bit x + 2 y + 4 z is 1 where the corner at this
  /// offset is cut. `bytes` has room for grid().count().
  void write_cells(std::span<std::uint8_t> bytes) const;

 private:
  void apply(const CutList& list, const CutList::Cut& cut);
  void cut_lasso(const CutList::Cut& cut, std::span<const float> outline);
  void cut_balls(const CutList::Cut& cut, std::span<const float> centres);

  CutList list_;
  CutGrid grid_;
  std::vector<std::uint8_t> corners_;  // 1: cut
};

/// Of the balls of a cut: each cuts the corner that is nearest to its centre, at least.
double ball_radius_mm(const CutList::Cut& cut, const CutGrid& grid);

/// Of pass 1, for a mask of this grid; without a cut the grid is not used.
void set_cuts(shaders::CastParameters& to, const CutList& list, const CutGrid& grid);

}  // namespace fanlight
