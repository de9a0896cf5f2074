// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/sector_guess.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

// Grey levels above the background's up to this one are noise, as JPEG leaves it.
constexpr int kNoise = 8;
// A corner brighter than this is no background.
constexpr int kBrightestBackground = 64;
// A row with fewer adjacent bright pixels has a letter in it, or nothing.
constexpr std::uint32_t kLeastRun = 6;
constexpr int kTries = 400;
constexpr double kOnLinePixels = 1.5;
constexpr double kLeastShare = 0.2;
// Edges that meet farther away than this many heights of the frame are parallel.
constexpr double kParallelHeights = 20;

/// Border of the bright pixels in a row.
struct Border {
  double row;
  double column;
};

/// column = at_row_0 + slope * row
struct Edge {
  double at_row_0 = 0;
  double slope = 0;
  double length = 0;  ///< of the borders on it, pixels

  double column(double row) const { return at_row_0 + slope * row; }
};

struct Borders {
  std::vector<Border> left;
  std::vector<Border> right;
};

/// The pixels that are brighter than the darkest corner: black of a video may be 16.
std::vector<std::uint8_t> bright_pixels(std::span<const std::uint8_t> brightest, std::uint32_t columns) {
  const int darkest_corner = std::min(
      {brightest.front(), brightest[columns - 1], brightest[brightest.size() - columns], brightest.back()});
  const int background = std::min(darkest_corner, kBrightestBackground) + kNoise;
  std::vector<std::uint8_t> bright(brightest.size());
  std::ranges::transform(brightest, bright.begin(), [=](int grey) { return grey > background ? 1 : 0; });
  return bright;
}

bool bright_run(std::span<const std::uint8_t> row, std::size_t from) {
  if (from + kLeastRun > row.size()) return false;
  return std::ranges::all_of(row.subspan(from, kLeastRun), [](std::uint8_t bright) { return bright != 0; });
}

/// Only borders within the frame: at its rim the sector is cut off.
Borders borders_of(std::span<const std::uint8_t> brightest, std::uint32_t columns, std::uint32_t rows) {
  Borders borders;
  for (std::uint32_t row = 0; row < rows; ++row) {
    const auto pixels = brightest.subspan(std::size_t{row} * columns, columns);
    std::size_t left = 0;
    while (left < columns && !bright_run(pixels, left)) ++left;
    if (left == columns) continue;
    std::size_t right = columns - kLeastRun;
    while (!bright_run(pixels, right)) --right;
    right += kLeastRun - 1;
    if (left > 0) borders.left.push_back({static_cast<double>(row), static_cast<double>(left)});
    if (right + 1 < columns) borders.right.push_back({static_cast<double>(row), static_cast<double>(right)});
  }
  return borders;
}

Edge through(const Border& one, const Border& other) {
  const double slope = (other.column - one.column) / (other.row - one.row);
  return {.at_row_0 = one.column - slope * one.row, .slope = slope};
}

bool lies_on(const Border& border, const Edge& edge) {
  // Across the edge, not along the row.
  return std::abs(border.column - edge.column(border.row)) <= kOnLinePixels * std::hypot(1.0, edge.slope);
}

/// Least squares through the borders near the edge.
Edge refined(const std::vector<Border>& borders, const Edge& edge) {
  double count = 0;
  double rows = 0;
  double columns = 0;
  double rows_rows = 0;
  double rows_columns = 0;
  for (const Border& border : borders) {
    if (!lies_on(border, edge)) continue;
    ++count;
    rows += border.row;
    columns += border.column;
    rows_rows += border.row * border.row;
    rows_columns += border.row * border.column;
  }
  const double spread = count * rows_rows - rows * rows;
  if (count < 3 || spread <= 0) return edge;
  const double slope = (count * rows_columns - rows * columns) / spread;
  return {.at_row_0 = (columns - slope * rows) / count, .slope = slope, .length = edge.length};
}

std::optional<Edge> straight_edge(const std::vector<Border>& borders, std::uint32_t rows) {
  if (borders.size() < 10) return std::nullopt;
  std::minstd_rand random(18);  // the same for every call
  std::uniform_int_distribution<std::size_t> any(0, borders.size() - 1);
  Edge best;
  for (int i = 0; i < kTries; ++i) {
    const Border& one = borders[any(random)];
    const Border& other = borders[any(random)];
    if (std::abs(one.row - other.row) < 0.05 * rows) continue;
    Edge edge = through(one, other);
    const auto on_it =
        std::ranges::count_if(borders, [&](const Border& border) { return lies_on(border, edge); });
    // A flat edge has few rows: a sector of 150 degrees is wide at once.
    edge.length = static_cast<double>(on_it) * std::hypot(1.0, edge.slope);
    if (edge.length > best.length) best = edge;
  }
  if (best.length < kLeastShare * rows) return std::nullopt;
  return refined(borders, best);
}

/// Bright rows along a line, from the begin of the longest bright stretch to the last bright row.
struct Along {
  double first;
  double last;
};
std::optional<Along> bright_along(std::span<const std::uint8_t> brightest, std::uint32_t columns,
                                  std::uint32_t rows, double column_at_row_0, double slope) {
  const double most_gap = 0.02 * rows;
  std::optional<Along> longest;  // letters above the sector are short
  std::optional<Along> stretch;
  std::uint32_t run = 0;
  double last = 0;
  for (std::uint32_t row = 0; row < rows; ++row) {
    const double column = std::round(column_at_row_0 + slope * row);
    const bool bright = column >= 0 && column < columns &&
                        brightest[std::size_t{row} * columns + static_cast<std::size_t>(column)] != 0;
    run = bright ? run + 1 : 0;
    if (run < kLeastRun) continue;
    const double begin = row + 1.0 - run;
    if (!stretch || begin - stretch->last > most_gap) stretch = Along{.first = begin, .last = begin};
    stretch->last = last = row;
    if (!longest || stretch->last - stretch->first > longest->last - longest->first) longest = stretch;
  }
  if (longest) longest->last = last;
  return longest;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

std::optional<SectorGuess> guess_sector(std::span<const std::uint8_t> all_brightest, std::uint32_t columns,
                                        std::uint32_t rows, double column_rows) {
  const std::vector<std::uint8_t> brightest = bright_pixels(all_brightest, columns);
  const Borders borders = borders_of(brightest, columns, rows);
  const auto left = straight_edge(borders.left, rows);
  const auto right = straight_edge(borders.right, rows);
  if (!left || !right) return std::nullopt;
  SectorGuess guess;
  const double widens = right->slope - left->slope;  // columns a row
  const double width = right->at_row_0 - left->at_row_0;
  guess.diverges = widens > 0 && std::abs(width / widens) < kParallelHeights * rows;

  std::vector<double> firsts;
  std::vector<double> lasts;
  constexpr int kRays = 41;
  if (guess.diverges) {
    guess.apex_row = -width / widens;
    const double apex_column = left->column(guess.apex_row);
    const double left_rad = std::atan(left->slope * column_rows);
    const double right_rad = std::atan(right->slope * column_rows);
    guess.half_angle_deg = degrees((right_rad - left_rad) / 2);
    guess.lean_deg = degrees((right_rad + left_rad) / 2);
    guess.face_column = apex_column;
    for (int ray = 0; ray < kRays; ++ray) {
      const double rad = std::lerp(left_rad, right_rad, (ray + 4.0) / (kRays + 7.0));
      const double slope = std::tan(rad) / column_rows;
      const auto along = bright_along(brightest, columns, rows, apex_column - slope * guess.apex_row, slope);
      if (!along) continue;
      firsts.push_back((along->first - guess.apex_row) / std::cos(rad));
      lasts.push_back((along->last - guess.apex_row) / std::cos(rad));
    }
    if (firsts.empty()) return std::nullopt;
    guess.face_row = guess.apex_row + median(firsts);
    // Deep echoes are weak in places, and the frame may cut the sector off at its sides.
    std::ranges::sort(lasts);
    guess.last_row = guess.apex_row + lasts[lasts.size() * 3 / 4];
  } else {
    const double middle_row = rows / 2.0;
    guess.left_column = left->column(middle_row);
    guess.right_column = right->column(middle_row);
    guess.face_column = (guess.left_column + guess.right_column) / 2;
    for (int ray = 0; ray < kRays; ++ray) {
      const double column = std::lerp(guess.left_column, guess.right_column, (ray + 4.0) / (kRays + 7.0));
      const auto along = bright_along(brightest, columns, rows, column, 0);
      if (!along) continue;
      firsts.push_back(along->first);
      lasts.push_back(along->last);
    }
    if (firsts.empty()) return std::nullopt;
    guess.face_row = median(firsts);
    guess.last_row = median(lasts);
  }
  // Edges of different things may meet anywhere.
  const bool in_order =
      guess.last_row > guess.face_row && (!guess.diverges || guess.face_row > guess.apex_row);
  return in_order ? std::optional(guess) : std::nullopt;
}

StepGuesser::StepGuesser(std::uint32_t columns, std::uint32_t rows, const SectorGuess& sector)
    : columns_(columns), between_columns_(kMostColumns + 1) {
  const double depth = sector.last_row - sector.face_row;
  first_row_ = static_cast<std::uint32_t>(std::clamp(sector.face_row + 0.4 * depth, 0.0, rows - 1.0));
  end_row_ = static_cast<std::uint32_t>(std::clamp(sector.face_row + 0.6 * depth, 0.0, rows - 1.0)) + 1;
  const double half_width = 0.15 * columns;
  first_column_ = static_cast<std::uint32_t>(std::clamp(sector.face_column - half_width, 0.0, columns - 1.0));
  end_column_ = static_cast<std::uint32_t>(std::clamp(sector.face_column + half_width, 0.0, columns - 1.0));
}

/// Pearson's correlation over the middle of the sector.
double StepGuesser::likeness(std::span<const std::uint8_t> one, std::span<const std::uint8_t> other,
                             std::size_t shift) const {
  double sums[5] = {};
  double count = 0;
  for (std::uint32_t row = first_row_; row < end_row_; ++row) {
    for (std::size_t column = first_column_; column + kMostColumns < end_column_; ++column) {
      const double a = one[std::size_t{row} * columns_ + column];
      const double b = other[std::size_t{row} * columns_ + column + shift];
      const double terms[5] = {a, b, a * a, b * b, a * b};
      for (int i = 0; i < 5; ++i) sums[i] += terms[i];
      ++count;
    }
  }
  const double spread_a = count * sums[2] - sums[0] * sums[0];
  const double spread_b = count * sums[3] - sums[1] * sums[1];
  if (!(spread_a > 0) || !(spread_b > 0)) return 0;
  return (count * sums[4] - sums[0] * sums[1]) / std::sqrt(spread_a * spread_b);
}

void StepGuesser::add(std::span<const std::uint8_t> frame, std::span<const std::uint8_t> next) {
  between_frames_ += likeness(frame, next, 0);
  for (std::size_t shift = 0; shift <= kMostColumns; ++shift)
    between_columns_[shift] += likeness(frame, frame, shift);
  ++pairs_;
}

std::optional<StepGuess> StepGuesser::guess() const {
  if (pairs_ == 0) return std::nullopt;
  const double wanted = between_frames_ / pairs_;
  for (std::size_t shift = 1; shift <= kMostColumns; ++shift) {
    const double nearer = between_columns_[shift - 1] / pairs_;
    const double farther = between_columns_[shift] / pairs_;
    if (!(farther <= wanted && wanted < nearer)) continue;
    const double share = (nearer - wanted) / (nearer - farther);
    return StepGuess{.step_columns = static_cast<double>(shift) - 1 + share,
                     .likeness = wanted,
                     .row = (first_row_ + end_row_) / 2};
  }
  return std::nullopt;
}

}  // namespace fanlight
