// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/cut_mask.hpp"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <string>
#include <vector>

namespace fanlight {
namespace {

const CutGrid kGrid = CutGrid::around({.lowest = {-80, 0, -60}, .highest = {80, 160, 60}});

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
  const CutGrid& grid = kGrid;
  EXPECT_GT(grid.cell_mm, 1.5);
  EXPECT_LT(grid.cell_mm, 2);
  EXPECT_GE(grid.lowest.x + grid.cell_mm * grid.cells.x, 80 - 1e-9);
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
  ASSERT_TRUE(mask.update(cuts("inside" + square), kGrid));
  EXPECT_TRUE(is_cut(mask, {10, 50, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 10, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 110, 0}));
  EXPECT_FALSE(is_cut(mask, {-15, 50, 0}));
  EXPECT_TRUE(is_cut(mask, {-5, 50, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 50, 25}));
  ASSERT_TRUE(mask.update(cuts("outside" + square), kGrid));
  EXPECT_FALSE(is_cut(mask, {10, 50, 0}));
  EXPECT_FALSE(is_cut(mask, {-15, 10, 0}));
  EXPECT_TRUE(is_cut(mask, {-15, 50, 0}));
}

TEST(CutMaskTest, CutsAlongTheLinesFromTheEye) {
  // At depth 100 lines from an eye at -100 are twice as far apart as in the plane.
  CutMask mask;
  ASSERT_TRUE(mask.update(
      cuts("inside -3000 3000 from 0 0 0 right 1 0 0 up 0 0 1 eye 100 outline -20 -20 20 -20 20 20 -20 20"),
      kGrid));
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
      kGrid));
  EXPECT_TRUE(is_cut(mask, {-70, 80, 0}));
  EXPECT_TRUE(is_cut(mask, {70, 95, 15}));
  EXPECT_FALSE(is_cut(mask, {0, 105, 0}));
  EXPECT_FALSE(is_cut(mask, {0, 80, 25}));
}

TEST(CutMaskTest, CutsBalls) {
  CutMask mask;
  ASSERT_TRUE(mask.update(cuts("balls 6 at 0 80 0 20 80 0 500 0 0"), kGrid));
  EXPECT_TRUE(is_cut(mask, {0, 80, 0}));
  EXPECT_TRUE(is_cut(mask, {20, 84, 0}));
  EXPECT_FALSE(is_cut(mask, {10, 80, 0}));
  EXPECT_FALSE(is_cut(mask, {0, 88, 0}));
}

TEST(CutMaskTest, ChangesWithItsCutsAndWithAnotherBoxAlone) {
  const std::string first = "balls 6 at 0 80 0";
  CutMask mask;
  EXPECT_FALSE(mask.update({}, kGrid));
  EXPECT_TRUE(mask.update(cuts(first), kGrid));
  EXPECT_FALSE(mask.update(cuts(first), kGrid));
  EXPECT_TRUE(mask.update(cuts(first + "; balls 6 at 20 80 0"), kGrid));
  EXPECT_TRUE(is_cut(mask, {0, 80, 0}));
  EXPECT_TRUE(is_cut(mask, {20, 80, 0}));
  EXPECT_TRUE(mask.update(cuts(first), kGrid));  // undone
  EXPECT_FALSE(is_cut(mask, {20, 80, 0}));
  EXPECT_TRUE(mask.update(cuts(first + " 20 80 0"), kGrid));  // a longer stroke
  EXPECT_TRUE(is_cut(mask, {0, 80, 0}));
  EXPECT_TRUE(is_cut(mask, {20, 80, 0}));
  const CutGrid coarse = CutGrid::around({.lowest = {-160, 0, -120}, .highest = {160, 320, 120}});
  EXPECT_TRUE(mask.update(cuts(first), coarse));
  EXPECT_TRUE(is_cut(mask, {0, 80, 0}));
  EXPECT_TRUE(mask.update({}, coarse));
}

TEST(CutMaskTest, CutsTheNearestCornerOfTheSmallestBall) {
  CutMask mask;
  ASSERT_TRUE(mask.update(cuts("balls 0.5 at 3.3 80.9 7.7"), kGrid));
  EXPECT_TRUE(is_cut(mask, {3.3, 80.9, 7.7}));
}

}  // namespace
}  // namespace fanlight
