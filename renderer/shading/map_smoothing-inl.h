// SPDX-License-Identifier: Apache-2.0
// The last step of the depth map's filter, pass 2: smooth.comp, or mean_rows.comp and mean_columns.comp, for
// a vector of pixels. See shaders/ for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_SHADING_MAP_SMOOTHING) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_MAP_SMOOTHING
#undef FANLIGHT_RENDERER_SHADING_MAP_SMOOTHING
#else
#define FANLIGHT_RENDERER_SHADING_MAP_SMOOTHING
#endif

#include <cmath>

#include "renderer/shading/row_access-inl.h"
#include "renderer/shading/surface_map-inl.h"
#include "renderer/shading/surface_shading.hpp"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

constexpr float kMinSpread = 0.02F;

// A Gaussian over whole distances, in pixels.
class Shares {
 public:
  Shares(float fall, int radius) : fall_(fall) {
    for (int distance = 0; distance <= std::min(radius, kKept - 1); ++distance)
      kept_[distance] = share(distance);
  }

  float at(int distance) const { return distance < kKept ? kept_[distance] : share(distance); }

 private:
  static constexpr int kKept = 64;
  float share(int distance) const {
    const auto pixels = static_cast<float>(distance);
    return std::exp(-pixels * pixels * fall_);
  }

  float fall_;
  float kept_[kKept];
};

class MapSmoothing {
 public:
  explicit MapSmoothing(const Memory& memory)
      : memory_(memory),
        lighting_(*memory.lighting),
        width_(static_cast<int>(memory.lighting->width)),
        height_(static_cast<int>(memory.lighting->height)) {}

  // One half of the smoothing filter, along rows or along columns.
  void smooth(int column, int row, int count, bool columns, bool keeps_edges, const Shares& shares) const {
    const Mask present = hn::Gt(small_number_of(weights_from(column, row)), zero());
    const Floats middle = columns ? row_depths_from(column, row) : filled_from(column, row);
    Floats fitted = middle;
    if (!is_empty(present)) fitted = line_through(column, row, columns, keeps_edges, middle, shares);
    if (columns) {
      const Floats depth = where(present, fitted, all(kNoSurface));
      return write_row(words_of(depth), words_at(memory_.smooth_depth, column, row), count);
    }
    write_pairs({words_of(fitted), hn::Zero(kWords)}, memory_.row_sums + 2 * (start_of(row) + offset(column)),
                count);
  }

  // The moving average along a row.
  void sum_row(int row) const {
    const int radius = lighting_.filter_radius;
    const int first = lighting_.smooth_left;
    const int end = std::min(lighting_.smooth_right, width_);
    std::uint32_t depths = 0;
    std::uint32_t weights = 0;
    std::uint32_t* const sums = memory_.row_sums + 2 * start_of(row);
    for (int x = std::max(first - radius, 0); x < std::min(first + radius, width_); ++x)
      add_weighted(row, x, 1, depths, weights);
    for (int x = first; x < end; ++x) {
      if (x + radius < width_) add_weighted(row, x + radius, 1, depths, weights);
      sums[2 * x] = depths;
      sums[2 * x + 1] = weights;
      // Whole numbers: what is added is taken away again, also where it wraps.
      if (x >= radius) add_weighted(row, x - radius, ~std::uint32_t{0}, depths, weights);
    }
  }

  // The moving average along a run of columns.
  void average_columns(int column, int count) const {
    const int radius = lighting_.filter_radius;
    const int first = lighting_.smooth_top;
    const int end = std::min(lighting_.smooth_bottom, height_);
    WordPairs sum = {hn::Zero(kWords), hn::Zero(kWords)};
    for (int y = first - radius; y < first + radius; ++y) add_row(sum, column, y, true);
    for (int y = first; y < end; ++y) {
      add_row(sum, column, y + radius, true);
      const Floats weights = hn::Max(number_of(sum.second), all(1.0F));
      const Floats mean =
          all(lighting_.depth_white) + number_of(sum.first) / (all(lighting_.sum_units) * weights);
      const Mask present = hn::Gt(small_number_of(weights_from(column, y)), zero());
      write_row(words_of(where(present, mean, all(kNoSurface))), words_at(memory_.smooth_depth, column, y),
                count);
      add_row(sum, column, y - radius, false);
    }
  }

 private:
  static std::size_t offset(int index) { return static_cast<std::size_t>(index); }
  std::size_t start_of(int row) const { return offset(row) * offset(width_); }
  std::uint32_t* words_at(float* map, int column, int row) const {
    return reinterpret_cast<std::uint32_t*>(map + start_of(row) + offset(column));
  }
  Floats filled_from(int column, int row) const {
    return read_row(memory_.filled + start_of(row), column, 0, width_ - 1);
  }
  Floats row_depths_from(int column, int row) const {
    return floats_of(read_pairs(memory_.row_sums + 2 * start_of(row), column, 0, width_ - 1).first);
  }
  Words weights_from(int column, int row) const {
    return read_row(memory_.weights + start_of(row), column, 0, width_ - 1);
  }

  // The value in the middle of a weighted line through the depths of a window.
  Floats line_through(int column, int row, bool columns, bool keeps_edges, Floats middle,
                      const Shares& shares) const {
    const int radius = lighting_.filter_radius;
    Floats weights = zero();
    Floats distances = zero();
    Floats squares = zero();
    Floats depths = zero();
    Floats moments = zero();
    for (int each = -radius; each <= radius; ++each) {
      const int x = columns ? column : column + each;
      const int y = columns ? row + each : row;
      if (y < 0 || y >= height_) continue;
      const Floats depth = columns ? row_depths_from(x, y) : filled_from(x, y);
      const Floats difference = depth - middle;
      Floats weight = small_number_of(weights_from(x, y)) * all(shares.at(std::abs(each)));
      if (!columns && !lies_between(x, 0, width_ - 1))
        weight =
            hn::IfThenElseZero(lies_within(hn::Iota(kFloats, static_cast<float>(x)), 0, width_ - 1), weight);
      if (keeps_edges) {
        const Floats ratio = difference / all(lighting_.same_surface);
        const Floats similarity = hn::Max(all(1.0F) - ratio * ratio, zero());
        weight = weight * similarity * similarity;
      }
      const Floats distance = all(static_cast<float>(each));
      const Floats product = hn::IfThenElseZero(hn::Gt(weight, zero()), weight * difference);
      weights = weights + weight;
      distances = distances + weight * distance;
      squares = squares + weight * distance * distance;
      depths = depths + product;
      moments = moments + product * distance;
    }
    const Floats determinant = weights * squares - distances * distances;
    const Mask is_line = hn::Gt(determinant, all(kMinSpread) * weights * squares);
    const Floats line = (squares * depths - distances * moments) / determinant;
    return middle + where(is_line, line, depths / hn::Max(weights, all(1e-30F)));
  }

  // Adds the weighted depth and the weight of a pixel, `times` modulo 2^32.
  void add_weighted(int row, int column, std::uint32_t times, std::uint32_t& depths,
                    std::uint32_t& weights) const {
    const std::size_t pixel = start_of(row) + offset(column);
    const std::uint32_t weight = times * memory_.weights[pixel];
    const float height = std::max(memory_.filled[pixel] - lighting_.depth_white, 0.0F);
    depths += weight * static_cast<std::uint32_t>(height * lighting_.sum_units + 0.5F);
    weights += weight;
  }

  void add_row(WordPairs& sum, int column, int row, bool enters) const {
    if (row < 0 || row >= height_) return;
    const WordPairs more = read_pairs(memory_.row_sums + 2 * start_of(row), column, 0, width_ - 1);
    sum.first = enters ? sum.first + more.first : sum.first - more.first;
    sum.second = enters ? sum.second + more.second : sum.second - more.second;
  }

  const Memory& memory_;
  const shaders::LightParameters& lighting_;
  int width_;
  int height_;
};

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
