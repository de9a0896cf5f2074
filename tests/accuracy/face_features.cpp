// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/face_features.hpp"

#include <cmath>
#include <numbers>

namespace fanlight::test {

namespace {

/// The nearest pixel's depth; negative outside the picture.
double depth_near(std::span<const double> depth_mm, PictureSize size, double column, double row) {
  const double x = std::round(column);
  const double y = std::round(row);
  if (x < 0 || y < 0 || x >= size.width || y >= size.height) return -1;
  return depth_mm[static_cast<std::size_t>(y) * size.width + static_cast<std::size_t>(x)];
}

/// By how much a pixel is nearer than the mean of the circle about it, mm.
std::optional<double> height_over_ring(std::span<const double> depth_mm, PictureSize size, double column,
                                       double row, double radius_pixels) {
  constexpr int kPoints = 24;
  const double here = depth_near(depth_mm, size, column, row);
  double sum = 0;
  for (int point = 0; point < kPoints; ++point) {
    const double angle = 2 * std::numbers::pi * point / kPoints;
    const double there = depth_near(depth_mm, size, column + radius_pixels * std::cos(angle),
                                    row + radius_pixels * std::sin(angle));
    if (there < 0) return std::nullopt;
    sum += there;
  }
  if (here < 0) return std::nullopt;
  return sum / kPoints - here;
}

}  // namespace

std::optional<FoundFeature> found_feature(const FaceFeature& feature, std::span<const double> depth_mm,
                                          PictureSize size, double pixel_mm) {
  const double middle_column = (size.width - 1.0) / 2;
  const double middle_row = (size.height - 1.0) / 2;
  std::optional<FoundFeature> found;
  for (std::uint32_t row = 0; row < size.height; ++row) {
    for (std::uint32_t column = 0; column < size.width; ++column) {
      const double right_mm = (column - middle_column) * pixel_mm;
      const double up_mm = (middle_row - row) * pixel_mm;
      if (std::hypot(right_mm - feature.right_mm, up_mm - feature.up_mm) > feature.within_mm) continue;
      const auto height = height_over_ring(depth_mm, size, column, row, feature.ring_mm / pixel_mm);
      if (!height) continue;
      const double height_mm = feature.is_groove ? -*height : *height;
      if (!found || height_mm > found->height_mm) found = {right_mm, up_mm, height_mm};
    }
  }
  return found;
}

}  // namespace fanlight::test
