// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/cell_sets.hpp"

namespace fanlight {

Cell cell_of(const CellBox& box, std::size_t index) {
  const std::size_t row = index / box.size[0];
  return {.i = static_cast<std::uint32_t>(index % box.size[0]),
          .j = static_cast<std::uint32_t>(row % box.size[1]),
          .k = static_cast<std::uint32_t>(row / box.size[1])};
}

Cells steps_within(const CellBox& box, const Cells& cells, std::uint32_t most) {
  Cells steps(cells.size());
  std::vector<std::size_t> front;
  std::vector<std::size_t> next;
  for (std::size_t index = 0; index < cells.size(); ++index) {
    steps[index] = cells[index] != 0 ? static_cast<std::uint8_t>(most) : 0;
    if (cells[index] != 0) continue;
    bool is_beside = false;
    each_neighbour(box, index, [&](std::size_t other) { is_beside |= cells[other] != 0; });
    if (is_beside) front.push_back(index);
  }
  for (std::uint32_t step = 1; step < most && !front.empty(); ++step) {
    next.clear();
    for (const std::size_t index : front) {
      each_neighbour(box, index, [&](std::size_t other) {
        if (cells[other] == 0 || steps[other] < most) return;
        steps[other] = static_cast<std::uint8_t>(step);
        next.push_back(other);
      });
    }
    front.swap(next);
  }
  return steps;
}

Cells spread(const CellBox& box, std::vector<std::size_t> from, const Cells& may, std::size_t most) {
  Cells found(may.size());
  for (const std::size_t index : from) found[index] = 1;
  std::vector<std::size_t> next;
  for (std::size_t step = 0; step < most && !from.empty(); ++step) {
    next.clear();
    for (const std::size_t index : from) {
      each_neighbour(box, index, [&](std::size_t other) {
        if (may[other] == 0 || found[other] != 0) return;
        found[other] = 1;
        next.push_back(other);
      });
    }
    from.swap(next);
  }
  return found;
}

std::vector<std::size_t> indices_of(const Cells& cells) {
  std::vector<std::size_t> indices;
  for (std::size_t index = 0; index < cells.size(); ++index)
    if (cells[index] != 0) indices.push_back(index);
  return indices;
}

}  // namespace fanlight
