// SPDX-License-Identifier: Apache-2.0
// The outlines of pass 3, by the twin that TwinTest compares with the shader, against the true coverage of
// pixels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "proto/model/scene.hpp"
#include "renderer/passes/pixel_rect.hpp"
#include "tests/support/cpu_twin.hpp"

namespace fanlight::test {
namespace {

constexpr PictureSize kSize{.width = 96, .height = 96};
constexpr double kDepthMm = 50;

struct Edge {
  double angle_rad;
  double distance;  // of the middle of the picture, pixels

  double inside(double x, double y) const {
    return (x - 47.5) * std::cos(angle_rad) + (y - 47.5) * std::sin(angle_rad) + distance;
  }
  /// Share of the pixel that lies inside.
  double coverage(int column, int row) const {
    constexpr int kParts = 16;
    int count = 0;
    for (int part = 0; part < kParts * kParts; ++part) {
      const double x = column - 0.5 + (part % kParts + 0.5) / kParts;
      const double y = row - 0.5 + (part / kParts + 0.5) / kParts;
      if (inside(x, y) >= 0) ++count;
    }
    return static_cast<double>(count) / (kParts * kParts);
  }
};

/// The mean error of the coverage over the pixels that the edge crosses, with outlines of this radius.
/// `behind_mm`: of a black surface outside, or none.
double mean_error(const Edge& edge, int radius, double behind_mm) {
  Scene scene;
  scene.finish.outline = radius;
  std::vector<double> depths_mm;
  std::vector<Rgb> lit;
  for (int row = 0; row < 96; ++row) {
    for (int column = 0; column < 96; ++column) {
      const bool inside = edge.inside(column, row) >= 0;
      depths_mm.push_back(inside ? kDepthMm : behind_mm);
      lit.emplace_back(inside ? 1 : 0);
    }
  }
  const auto outlined = twin_outline(lit, depths_mm, kSize, scene);
  double sum = 0;
  int crossed = 0;
  for (int row = 8; row < 88; ++row) {
    for (int column = 8; column < 88; ++column) {
      const double truth = edge.coverage(column, row);
      if (truth <= 0 || truth >= 1) continue;
      const double shown = outlined[static_cast<std::size_t>(row * 96 + column)].x;
      sum += std::abs(shown * shown - truth);
      ++crossed;
    }
  }
  return crossed > 0 ? sum / crossed : 0;
}

TEST(Outline, ShowsTheCoverageOfStraightOutlinesAtEachAngle) {
  for (const double behind_mm : {kNoSurface, kDepthMm + 40}) {
    double stairs = 0;
    double smooth = 0;
    int count = 0;
    for (int degrees = 4; degrees < 90; degrees += 7) {
      const Edge edge{.angle_rad = degrees * std::numbers::pi / 180, .distance = 0.13 * degrees};
      const double now = mean_error(edge, 3, behind_mm);
      // The steps of an outline that is nearly along the pixels are longer than the window.
      EXPECT_LT(now, degrees > 10 && degrees < 80 ? 0.12 : 0.23) << degrees << " degrees";
      stairs += mean_error(edge, 0, behind_mm);
      smooth += now;
      ++count;
    }
    EXPECT_GT(stairs / count, 0.2) << "the test measures nothing";
    EXPECT_LT(smooth, 0.4 * stairs) << "mean error " << smooth / count << ", with stairs " << stairs / count;
  }
}

TEST(Outline, ReachesTheNextTilesAtMost) {
  // cleanup_tiles.comp looks no farther.
  EXPECT_LE(find_scene_field("finish.outline")->maximum, kTileSide);
}

TEST(Outline, LeavesAnOutlineAlongThePixels) {
  for (const double angle_rad : {0.0, std::numbers::pi / 2}) {
    const Edge edge{.angle_rad = angle_rad, .distance = 0};
    Scene scene;
    scene.finish.outline = 4;
    std::vector<double> depths_mm;
    std::vector<Rgb> lit;
    for (int pixel = 0; pixel < 96 * 96; ++pixel) {
      const bool inside = edge.inside(pixel % 96, pixel / 96) >= 0;
      depths_mm.push_back(inside ? kDepthMm : kNoSurface);
      lit.emplace_back(inside ? 1 : 0);
    }
    const auto outlined = twin_outline(lit, depths_mm, kSize, scene);
    // At the border of the picture the window is cut off, and sees the outline a little elsewhere.
    for (std::size_t pixel = 0; pixel < lit.size(); ++pixel) {
      const auto [row, column] = std::pair(pixel / 96, pixel % 96);
      const bool at_border = std::min(row, column) < 4 || std::max(row, column) > 91;
      ASSERT_NEAR(outlined[pixel].x, lit[pixel].x, at_border ? 0.2 : 1e-6) << column << ", " << row;
    }
  }
}

}  // namespace
}  // namespace fanlight::test
