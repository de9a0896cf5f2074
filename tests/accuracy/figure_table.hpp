// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace fanlight::test {

/// The bound that a figure has to meet.
struct Demand {
  enum class Side { kAtMost, kAtLeast } side;
  double bound;
};
constexpr Demand at_most(double bound) {
  return {Demand::Side::kAtMost, bound};
}
constexpr Demand at_least(double bound) {
  return {Demand::Side::kAtLeast, bound};
}

struct Figure {
  std::string name;  ///< with its unit
  double value = 0;
  int digits = 3;  ///< after the point
  std::optional<Demand> demand = {};

  /// Meets its demand, or has none. False for NaN with a demand: not measured.
  bool reached() const;
};

struct FigureRow {
  std::string name;
  std::vector<Figure> figures;
};

/// Rows with the same figures, under one heading.
struct FigureBlock {
  std::string title;
  std::string legend;
  std::vector<FigureRow> rows;
};

/// One sentence for each figure that does not meet its demand.
std::vector<std::string> failures(const std::vector<FigureBlock>& blocks);

/// A table for reading, with `!` behind each figure that does not meet its demand. Omits blocks without rows.
std::string as_text(const std::vector<FigureBlock>& blocks);

std::string as_json(const std::vector<FigureBlock>& blocks);

}  // namespace fanlight::test
