// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/twin_map.hpp"

namespace fanlight::test {

namespace {

/// The weight of a pixel in the filter (holes.comp).
double weight(const Scene::Filter& filter, double confidence) {
  if (filter.weights == FilterWeights::kEven) return 1;
  return std::clamp(std::floor(4 * confidence + 0.5), 1.0, 15.0);
}

/// Tukey's biweight: 0 from a difference of one step on, so that another surface does not contribute.
double likeness(double difference_mm, double step_mm) {
  if (std::abs(difference_mm) >= step_mm) return 0;
  const double share = difference_mm / step_mm;
  return (1 - share * share) * (1 - share * share);
}

/// The weighted mean over a square window. The weight is that of the pixel * weigh(columns away) * weigh(rows
/// away).
template <typename Weigh>
std::vector<double> window_mean(const TwinMap& map, int radius, const std::vector<double>& weights,
                                Weigh weigh, std::vector<double> smooth_mm) {
  map.for_each([&](int column, int row) {
    if (!map.surface(column, row)) return;
    double sum = 0;
    double total = 0;
    map.for_each_near(column, row, radius, radius, [&](int x, int y) {
      if (!map.surface(x, y)) return;
      const double share = weigh(x - column) * weigh(y - row) * weights[map.index(x, y)];
      sum += share * map.depth(x, y);
      total += share;
    });
    smooth_mm[map.index(column, row)] = sum / total;
  });
  return smooth_mm;
}

/// Fits a line to the neighbours of each pixel, up to `columns` or `rows` away, and takes its value at the
/// pixel. The weight is that of the neighbour * `weigh`(distance) * `like`(difference in depth). Takes the
/// mean where the distances have too little variance for a line (smooth.comp).
template <typename Weigh, typename Like>
std::vector<double> line_fit(const TwinMap& map, int columns, int rows, const std::vector<double>& weights,
                             const Weigh& weigh, const Like& like, std::vector<double> smooth_mm) {
  map.for_each([&](int column, int row) {
    if (!map.surface(column, row)) return;
    const double centre_mm = map.depth(column, row);
    double total = 0;
    double first = 0;
    double second = 0;
    double depth = 0;
    double slope = 0;
    map.for_each_near(column, row, columns, rows, [&](int x, int y) {
      if (!map.surface(x, y)) return;
      const int away = x - column + y - row;
      const double difference_mm = map.depth(x, y) - centre_mm;
      const double share = weigh(away) * weights[map.index(x, y)] * like(difference_mm);
      total += share;
      first += share * away;
      second += share * away * away;
      depth += share * difference_mm;
      slope += share * away * difference_mm;
    });
    const double determinant = total * second - first * first;
    const bool spread = determinant > 0.02 * total * second;
    smooth_mm[map.index(column, row)] =
        centre_mm + (spread ? (second * depth - first * slope) / determinant : depth / total);
  });
  return smooth_mm;
}

}  // namespace

std::vector<double> twin_islands(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm) {
  const TwinMap map(depth_mm, size, viewport(scene, size));
  const int radius = scene.filter.islands / 2;
  std::vector<double> cleaned_mm = depth_mm;
  if (radius == 0) return cleaned_mm;
  map.for_each([&](int column, int row) {
    if (!map.surface(column, row)) return;
    int pixels = 0;
    int of_surface = 0;
    map.for_each_near(column, row, radius, radius, [&](int x, int y) {
      ++pixels;
      const double apart_mm = std::abs(map.depth(x, y) - map.depth(column, row));
      of_surface += map.surface(x, y) && apart_mm <= scene.filter.step_mm ? 1 : 0;
    });
    if (4 * of_surface < pixels) cleaned_mm[map.index(column, row)] = kNoSurface;
  });
  return cleaned_mm;
}

std::vector<double> twin_holes(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm) {
  const TwinMap map(depth_mm, size, viewport(scene, size));
  const int radius = scene.filter.holes / 2;
  std::vector<double> filled_mm = depth_mm;
  if (radius == 0) return filled_mm;
  map.for_each([&](int column, int row) {
    if (map.surface(column, row)) return;
    const auto squared = [&](int x, int y) { return (x - column) * (x - column) + (y - row) * (y - row); };
    int pixels = 0;
    int with_surface = 0;
    int nearest_squared = 0;
    double nearest_mm = kNoSurface;
    map.for_each_near(column, row, radius, radius, [&](int x, int y) {
      ++pixels;
      if (!map.surface(x, y)) return;
      ++with_surface;
      if (nearest_mm >= 0 && squared(x, y) >= nearest_squared) return;
      nearest_squared = squared(x, y);
      nearest_mm = map.depth(x, y);
    });
    if (2 * with_surface < pixels || with_surface == 0) return;
    double sum = 0;
    double total = 0;
    map.for_each_near(column, row, radius, radius, [&](int x, int y) {
      if (!map.surface(x, y) || std::abs(map.depth(x, y) - nearest_mm) > scene.filter.step_mm) return;
      sum += map.depth(x, y) / squared(x, y);
      total += 1.0 / squared(x, y);
    });
    filled_mm[map.index(column, row)] = sum / total;
  });
  return filled_mm;
}

std::vector<double> twin_filter(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm,
                                const std::vector<double>& confidence) {
  const Scene::Filter& filter = scene.filter;
  const int radius = filter.size / 2;
  if (radius == 0) return depth_mm;
  const Viewport part = viewport(scene, size);
  const TwinMap map(depth_mm, size, part);
  std::vector<double> weights;
  weights.reserve(confidence.size());
  for (const double each : confidence) weights.push_back(weight(filter, each));

  if (filter.kind == DepthFilter::kMean) {
    return window_mean(
        map, radius, weights, [](int /*away*/) { return 1.0; }, depth_mm);
  }
  const double sigma = filter.size / 5.0;
  const auto bell = [=](int away) { return std::exp(-(away * away) / (2 * sigma * sigma)); };
  const auto like = [&](double difference_mm) {
    return filter.kind == DepthFilter::kGaussian ? 1.0 : likeness(difference_mm, filter.step_mm);
  };
  const auto along_rows_mm = line_fit(map, radius, 0, weights, bell, like, depth_mm);
  return line_fit({along_rows_mm, size, part}, 0, radius, weights, bell, like, along_rows_mm);
}

std::vector<double> twin_depth_filter(const Scene& scene, PictureSize size,
                                      const std::vector<double>& steady_mm, std::vector<double> confidence) {
  const auto cleaned_mm = twin_islands(scene, size, steady_mm);
  const auto filled_mm = twin_holes(scene, size, cleaned_mm);
  for (std::size_t pixel = 0; pixel < confidence.size(); ++pixel) {
    if (cleaned_mm[pixel] < 0) confidence[pixel] = 0;  // a depth that fills a hole was not measured
  }
  return twin_filter(scene, size, filled_mm, confidence);
}

}  // namespace fanlight::test
