// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/figure_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace fanlight::test {

namespace {

std::string words(const Demand& demand) {
  return fmt::format("{} {}", demand.side == Demand::Side::kAtMost ? "<=" : ">=", demand.bound);
}

std::string words(const Figure& figure) {
  if (std::isnan(figure.value) && !figure.demand) return "- ";
  return fmt::format("{:.{}f}{}", figure.value, figure.digits, figure.reached() ? " " : "!");
}

std::size_t width(const Figure& figure) {
  return std::max<std::size_t>(figure.name.size(), 8) + 2;
}

std::string heading(const FigureBlock& block, std::size_t name_width) {
  std::string names = fmt::format("{:<{}}", "", name_width);
  std::string demands = names;
  for (const Figure& figure : block.rows.front().figures) {
    names += fmt::format("{:>{}}", figure.name + " ", width(figure));
    demands += fmt::format("{:>{}}", figure.demand ? words(*figure.demand) + " " : "", width(figure));
  }
  return names + "\n" + demands + "\n";
}

std::string as_text(const FigureBlock& block) {
  std::size_t name_width = 0;
  for (const FigureRow& row : block.rows) name_width = std::max(name_width, row.name.size());
  std::string text = fmt::format("\n== {}\n{}\n\n{}", block.title, block.legend, heading(block, name_width));
  for (const FigureRow& row : block.rows) {
    text += fmt::format("{:<{}}", row.name, name_width);
    for (const Figure& figure : row.figures) text += fmt::format("{:>{}}", words(figure), width(figure));
    text += "\n";
  }
  return text;
}

}  // namespace

bool Figure::reached() const {
  if (!demand) return true;
  return demand->side == Demand::Side::kAtMost ? value <= demand->bound : value >= demand->bound;
}

std::vector<std::string> failures(const std::vector<FigureBlock>& blocks) {
  std::vector<std::string> failed;
  for (const FigureBlock& block : blocks) {
    for (const FigureRow& row : block.rows) {
      for (const Figure& figure : row.figures) {
        if (figure.reached()) continue;
        failed.push_back(fmt::format("{}: {} is {:.{}f}, expected {}", row.name, figure.name, figure.value,
                                     figure.digits, words(*figure.demand)));
      }
    }
  }
  return failed;
}

std::string as_text(const std::vector<FigureBlock>& blocks) {
  std::string text;
  for (const FigureBlock& block : blocks) {
    if (!block.rows.empty()) text += as_text(block);
  }
  return text;
}

std::string as_json(const std::vector<FigureBlock>& blocks) {
  nlohmann::ordered_json rows;
  for (const FigureBlock& block : blocks) {
    for (const FigureRow& row : block.rows) {
      for (const Figure& figure : row.figures) rows[row.name][figure.name] = figure.value;
    }
  }
  return nlohmann::ordered_json{{"rows", rows}, {"failures", failures(blocks)}}.dump(1);
}

}  // namespace fanlight::test
