// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/picture_likeness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace fanlight::test {

namespace {

/// Gaussian mean around each pixel; beyond the border the border's pixels are repeated.
std::vector<double> blurred(const std::vector<double>& values, PictureSize size) {
  constexpr int kReach = 5;
  constexpr double kDeviation = 1.5;
  std::array<double, 2 * kReach + 1> weights{};
  double sum = 0;
  for (int away = -kReach; away <= kReach; ++away)
    sum += weights[away + kReach] = std::exp(-0.5 * away * away / (kDeviation * kDeviation));
  const int width = static_cast<int>(size.width);
  const int height = static_cast<int>(size.height);
  const auto pass = [&](const std::vector<double>& from, int right, int down) {
    std::vector<double> to(from.size());
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        double mean = 0;
        for (int away = -kReach; away <= kReach; ++away) {
          const int x = std::clamp(column + away * right, 0, width - 1);
          const int y = std::clamp(row + away * down, 0, height - 1);
          mean += weights[away + kReach] / sum * from[static_cast<std::size_t>(y) * width + x];
        }
        to[static_cast<std::size_t>(row) * width + column] = mean;
      }
    }
    return to;
  };
  return pass(pass(values, 1, 0), 0, 1);
}

std::vector<double> products(std::span<const double> a, std::span<const double> b) {
  std::vector<double> made(a.size());
  std::ranges::transform(a, b, made.begin(), [](double x, double y) { return x * y; });
  return made;
}

struct Border {
  std::vector<std::pair<int, int>> pixels;  ///< marked ones beside one that is not
  double length = 0;
};

Border border_of(std::span<const std::uint8_t> marked, PictureSize size) {
  const int width = static_cast<int>(size.width);
  const int height = static_cast<int>(size.height);
  Border border;
  // The picture's own border is none.
  for (int row = 1; row + 1 < height; ++row) {
    for (int column = 1; column + 1 < width; ++column) {
      const auto at = [&](int x, int y) { return marked[static_cast<std::size_t>(y) * width + x] != 0; };
      if (!at(column, row)) continue;
      const int sides =
          !at(column - 1, row) + !at(column + 1, row) + !at(column, row - 1) + !at(column, row + 1);
      if (sides > 0) border.pixels.emplace_back(column, row);
      border.length += sides;
    }
  }
  return border;
}

}  // namespace

std::vector<double> structural_similarity(std::span<const double> a, std::span<const double> b,
                                          PictureSize size) {
  constexpr double kOfMeans = 0.01 * 0.01;
  constexpr double kOfDeviations = 0.03 * 0.03;
  const std::vector<double> mean_a = blurred({a.begin(), a.end()}, size);
  const std::vector<double> mean_b = blurred({b.begin(), b.end()}, size);
  const std::vector<double> square_a = blurred(products(a, a), size);
  const std::vector<double> square_b = blurred(products(b, b), size);
  const std::vector<double> product = blurred(products(a, b), size);
  std::vector<double> similarity(a.size());
  for (std::size_t i = 0; i < similarity.size(); ++i) {
    const double means = mean_a[i] * mean_b[i];
    const double squares = mean_a[i] * mean_a[i] + mean_b[i] * mean_b[i];
    similarity[i] = (2 * means + kOfMeans) * (2 * (product[i] - means) + kOfDeviations) /
                    ((squares + kOfMeans) * (square_a[i] + square_b[i] - squares + kOfDeviations));
  }
  return similarity;
}

Outline compared_outlines(std::span<const std::uint8_t> shown, std::span<const std::uint8_t> truth,
                          PictureSize size) {
  const Border shown_border = border_of(shown, size);
  const Border true_border = border_of(truth, size);
  double sum = 0;
  for (const auto& [column, row] : shown_border.pixels) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [x, y] : true_border.pixels)
      nearest = std::min(nearest, std::hypot(x - column, y - row));
    sum += nearest;
  }
  return {.mean_distance_pixels = sum / static_cast<double>(shown_border.pixels.size()),
          .length_ratio = shown_border.length / true_border.length};
}

}  // namespace fanlight::test
