// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "tests/support/cpu_twin.hpp"

namespace fanlight::test {

/// The depth map as pass 2 reads it: no surface outside the viewport. Keeps a reference to the depths.
class TwinMap {
 public:
  TwinMap(const std::vector<double>& depth_mm, PictureSize size, const Viewport& part)
      : depth_mm_(depth_mm),
        width_(size.width),
        left_(static_cast<int>(part.left)),
        top_(static_cast<int>(part.top)),
        right_(static_cast<int>(part.left + part.width) - 1),
        bottom_(static_cast<int>(part.top + part.height) - 1) {}

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column);
  }
  bool inside(int column, int row) const {
    return column >= left_ && column <= right_ && row >= top_ && row <= bottom_;
  }
  double depth(int column, int row) const {
    return inside(column, row) ? depth_mm_[index(column, row)] : kNoSurface;
  }
  bool surface(int column, int row) const { return depth(column, row) >= 0; }

  /// Calls visit(column, row) for each pixel of the viewport, along the rows.
  template <typename Visit>
  void for_each(Visit visit) const {
    for_each_in(left_, right_, top_, bottom_, visit);
  }

  /// The same for the window of up to `columns` and `rows` pixels around a pixel, clipped to the viewport.
  template <typename Visit>
  void for_each_near(int column, int row, int columns, int rows, Visit visit) const {
    for_each_in(std::max(left_, column - columns), std::min(right_, column + columns),
                std::max(top_, row - rows), std::min(bottom_, row + rows), visit);
  }

 private:
  template <typename Visit>
  static void for_each_in(int left, int right, int top, int bottom, Visit visit) {
    for (int row = top; row <= bottom; ++row) {
      for (int column = left; column <= right; ++column) visit(column, row);
    }
  }

  const std::vector<double>& depth_mm_;
  std::size_t width_;
  int left_;
  int top_;
  int right_;   // the last column
  int bottom_;  // the last row
};

}  // namespace fanlight::test
