// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/cut_mask.hpp"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <string>
#include <vector>

namespace fanlight {
namespace {

const Box kBox{.lowest = {-80, 0, -60}, .highest = {80, 160, 60}};

CutList cuts(const std::string& text) {
  auto list = CutList::parse(text);
  EXPECT_TRUE(list) << list.error().message;
  return *list;
}

/// Whether the first corner of the cell that is nearest to a point is cut.
bool is_cut(const CutMask& mask, const glm::dvec3& at) {
  const CutGrid& grid = mask.grid();
  std::vector<std::uint8_t> cells(grid.count());
  mask.write_cells(cells);
  const glm::dvec3 place = (at - grid.lowest) / grid.cell_mm;
  const std::size_t x = static_cast<std::size_t>(std::lround(place.x));
  const std::size_t y = static_cast<std::size_t>(std::lround(place.y));
  const std::size_t z = static_cast<std::size_t>(std::lround(place.z));
  return (cells[(z * grid.cells.y + y) * grid.cells.x + x] & 1U) != 0;
}

TEST(CutMaskTest, HasCellsOfAboutTwoMillimetres) {
  const CutGrid grid = CutGrid::around(kBox);
  EXPECT_GT(grid.cell_mm, 1.5);
  EXPECT_LT(grid.cell_mm, 2);
  EXPECT_TRUE(grid.contains(kBox));
  EXPECT_LE(grid.cells.x, CutGrid::kMostCells);
  EXPECT_LE(grid.cells.y, CutGrid::kMostCells);
  EXPECT_LE(grid.cells.z, CutGrid::kMostCells);
  const CutGrid small = CutGrid::around({.lowest = {0, 0, 0}, .highest = {10, 10, 10}});
  EXPECT_EQ(small.cell_mm, 0.5);
}

TEST(CutMaskTest, CutsWhatIsDrawn) {
  // A square of 40 mm about (10, 0), from depth 20 to 100.
  const std::string square =
      " 20 100 from 0 0 0 right 1 0 0 up 0 0 1 eye 0 outline -10 -20 30 -20 30 20 -10 20";
  CutMask mask;
  ASSERT_TRUE(mask.update(cuts("inside" + square), kBox));
  EXPECT_TRUE(is_cut(mask, {10, 50, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 10, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 110, 0}));
  EXPECT_FALSE(is_cut(mask, {-15, 50, 0}));
  EXPECT_TRUE(is_cut(mask, {-5, 50, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 50, 25}));
  ASSERT_TRUE(mask.update(cuts("outside" + square), kBox));
  EXPECT_FALSE(is_cut(mask, {10, 50, 0}));
  EXPECT_FALSE(is_cut(mask, {-15, 10, 0}));
  EXPECT_TRUE(is_cut(mask, {-15, 50, 0}));
}

TEST(CutMaskTest, CutsAlongTheLinesFromTheEye) {
  // At depth 100 lines from an eye at -100 are twice as far apart as in the plane.
  CutMask mask;
  ASSERT_TRUE(mask.update(
      cuts("inside -3000 3000 from 0 0 0 right 1 0 0 up 0 0 1 eye 100 outline -20 -20 20 -20 20 20 -20 20"),
      kBox));
  EXPECT_TRUE(is_cut(mask, {18, 0, 0}));
  EXPECT_FALSE(is_cut(mask, {24, 0, 0}));
  EXPECT_TRUE(is_cut(mask, {37, 100, 0}));
  EXPECT_FALSE(is_cut(mask, {44, 100, 0}));
}

TEST(CutMaskTest, CutsAlongARowOfTheGrid) {
  // Each row of corners is drawn as one point.
  CutMask mask;
  ASSERT_TRUE(mask.update(
      cuts("inside -3000 3000 from 0 80 0 right 0 1 0 up 0 0 1 eye 0 outline -20 -20 20 -20 20 20 -20 20"),
      kBox));
  EXPECT_TRUE(is_cut(mask, {-70, 80, 0}));
  EXPECT_TRUE(is_cut(mask, {70, 95, 15}));
  EXPECT_FALSE(is_cut(mask, {0, 105, 0}));
  EXPECT_FALSE(is_cut(mask, {0, 80, 25}));
}

TEST(CutMaskTest, CutsBalls) {
  CutMask mask;
  ASSERT_TRUE(mask.update(cuts("balls 6 at 0 80 0 20 80 0 500 0 0"), kBox));
  EXPECT_TRUE(is_cut(mask, {0, 80, 0}));
  EXPECT_TRUE(is_cut(mask, {20, 84, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 80, 0}));
  EXPECT_FALSE(is_cut(mask, {0, 88, 0}));
}

TEST(CutMaskTest, ChangesWithItsCutsAndWithAnotherBoxAlone) {
  const std::string first = "balls 6 at 0 80 0";
  CutMask mask;
  EXPECT_FALSE(mask.update({}, kBox));
  EXPECT_TRUE(mask.update(cuts(first), kBox));
  EXPECT_FALSE(mask.update(cuts(first), kBox));
  const Box wider{.lowest = kBox.lowest - 2.0, .highest = kBox.highest + 2.0};
  EXPECT_FALSE(mask.update(cuts(first), wider));
  EXPECT_TRUE(mask.update(cuts(first + "; balls 6 at 20 80 0"), kBox));
  EXPECT_TRUE(is_cut(mask, {0, 80, 0}));
  EXPECT_TRUE(is_cut(mask, {20, 80, 0}));
  EXPECT_TRUE(mask.update(cuts(first), kBox));  // undone
  EXPECT_FALSE(is_cut(mask, {20, 80, 0}));
  EXPECT_TRUE(mask.update(cuts(first), {.lowest = 2.0 * kBox.lowest, .highest = 2.0 * kBox.highest}));
  EXPECT_TRUE(is_cut(mask, {0, 80, 0}));
  EXPECT_TRUE(mask.update({}, kBox));
}

}  // namespace
}  // namespace fanlight
