#pragma once

#include <optional>
#include <string>
#include <vector>

namespace fanlight::test {

/// What is demanded of a figure.
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

  /// False for a NaN: what could not be measured is not reached.
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

/// A figure that does not reach what is demanded, in words.
std::vector<std::string> failures(const std::vector<FigureBlock>& blocks);

/// For a person, with `!` behind each figure that is not reached; blocks without rows are left out.
std::string as_text(const std::vector<FigureBlock>& blocks);

std::string as_json(const std::vector<FigureBlock>& blocks);

}  // namespace fanlight::test
