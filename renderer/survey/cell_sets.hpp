// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/survey/echo_grid.hpp"

namespace fanlight {

// Sets of cells of a box, and how they grow. Neighbours are the six that share a side.

/// A set: of each cell of a box 1, or 0.
using Cells = std::vector<std::uint8_t>;

struct Cell {
  std::uint32_t i = 0;
  std::uint32_t j = 0;
  std::uint32_t k = 0;
};

/// The place of a cell in the order of CellBox.
Cell cell_of(const CellBox& box, std::size_t index);

/// Calls `visit` with the index of each neighbour in the box.
template <typename Visit>
void each_neighbour(const CellBox& box, std::size_t index, Visit visit) {
  const Cell at = cell_of(box, index);
  const std::size_t row = box.size[0];
  const std::size_t slice = row * box.size[1];
  if (at.i > 0) visit(index - 1);
  if (at.i + 1 < box.size[0]) visit(index + 1);
  if (at.j > 0) visit(index - row);
  if (at.j + 1 < box.size[1]) visit(index + row);
  if (at.k > 0) visit(index - slice);
  if (at.k + 1 < box.size[2]) visit(index + slice);
}

/// How many steps each cell of the set is from the nearest cell that is not in it: 1 to `most`, which stands
/// for more too; 0 for cells that are not in it. `most`: 1 to 255.
Cells steps_within(const CellBox& box, const Cells& cells, std::uint32_t most);

/// `from`, and the cells of `may` that at most `most` steps through `may` lead to.
Cells spread(const CellBox& box, std::vector<std::size_t> from, const Cells& may, std::size_t most);

/// Of the cells of the set, ascending.
std::vector<std::size_t> indices_of(const Cells& cells);

}  // namespace fanlight
