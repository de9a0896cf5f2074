// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/window_across.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "proto/model/scene.hpp"
#include "shaders/cast_parameters.h"

namespace fanlight::test {
namespace {

TEST(WindowAcross, HasTheCentreAndTheSpreadOfAGrid) {
  for (const int window : {3, 5, 7}) {
    glm::dvec2 sum(0);
    glm::dvec2 squares(0);
    double products = 0;
    double farthest = 0;
    const auto points = points_across(window);
    for (const glm::dvec2& point : points) {
      sum += point;
      squares += point * point;
      products += point.x * point.y;
      farthest = std::max(farthest, glm::length(point));
    }
    const double count = static_cast<double>(points.size());
    double variance = 0;
    for (int at = -window / 2; at <= window / 2; ++at) variance += static_cast<double>(at * at) / window;
    EXPECT_EQ(points.size(), 3 * (window / 2));
    EXPECT_NEAR(glm::length(sum), 0, 1e-12);
    EXPECT_NEAR(squares.x / count, variance, 1e-12);
    EXPECT_NEAR(squares.y / count, variance, 1e-12);
    EXPECT_NEAR(products, 0, 1e-12);
    EXPECT_LT(farthest, 1.5 * (window / 2)) << "farther than the bounds of tile_bounds.h";
  }
}

TEST(WindowAcross, FitsTheShadersForAllThatAUserMaySet) {
  EXPECT_TRUE(points_across(1).empty());
  const SceneField* const field = find_scene_field("rays.window");
  ASSERT_NE(field, nullptr);
  EXPECT_LE(points_across(static_cast<int>(field->maximum)).size(),
            FANLIGHT_ACROSS_POINTS * FANLIGHT_MAX_ACROSS);
}

}  // namespace
}  // namespace fanlight::test
