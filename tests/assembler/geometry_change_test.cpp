// SPDX-License-Identifier: Apache-2.0
#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

class GeometryChange : public AssemblerTest {
 protected:
  GeometryChange() : AssemblerTest({.capacity = 20}) {}

  void change(std::uint32_t columns, std::uint32_t rows) {
    ++revision_;
    geometry_.columns = columns;
    geometry_.rows = rows;
  }
};

TEST_F(GeometryChange, BetweenSweepsTheNextVolumeHasTheNewOne) {
  add_sweep(0, 20, 0);
  change(3, 4);
  add_sweep(1, 20, 20);
  EXPECT_EQ(published(), 2U);
  EXPECT_EQ(counters_.geometry_changes.value(), 1U);
  const auto newest = ring_.take();
  EXPECT_EQ(newest->geometry(), geometry_);
  EXPECT_EQ(newest->stamp().frames, 20U);
  expect_identity();
}

TEST_F(GeometryChange, AmidstASweepGivesItsPartsUp) {
  add_sweep(0, 8, 20);
  change(3, 3);
  for (std::uint32_t i = 8; i < 20; ++i) add(frame(0, i, 20));
  EXPECT_EQ(published(), 0U);
  EXPECT_EQ(counters_.frames_abandoned.value(), 20U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  add_sweep(1, 20, 20);
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->geometry(), geometry_);
  expect_identity();
}

TEST_F(GeometryChange, NearTheEndOfASweepKeepsIt) {
  add_sweep(0, 18, 20);
  change(3, 3);
  add(frame(0, 18, 20));
  EXPECT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->geometry(), small_geometry());
  EXPECT_EQ(assembler_.frames_pending(), 1U);
  expect_identity();
}

TEST_F(GeometryChange, WithFramesMissingTheSweepIsIncomplete) {
  add_sweep(0, 10, 20);
  sequence_ += 5;
  add(frame(0, 15, 20));
  change(3, 3);
  add(frame(0, 16, 20));
  EXPECT_EQ(counters_.frames_in_incomplete_volumes.value(), 11U);
  expect_identity();
}

TEST_F(GeometryChange, AGeometryThatDoesNotFitIsCountedFrameByFrame) {
  add_sweep(0, 20, 20);
  change(5, 3);
  add_sweep(1, 20, 20);
  EXPECT_EQ(counters_.frames_misfit.value(), 20U);
  EXPECT_EQ(counters_.geometry_changes.value(), 1U);
  change(4, 3);
  add_sweep(2, 20, 20);
  EXPECT_EQ(published(), 2U);
  EXPECT_EQ(counters_.frames_missing.value(), 0U);
  expect_identity();
}

TEST_F(GeometryChange, AFrameOfTheOldOneIsLate) {
  add_sweep(0, 17, 20);
  const FrameStamp late = frame(0, 17, 20);
  add(frame(0, 18, 20));
  change(3, 3);
  add(frame(0, 19, 20));
  EXPECT_FALSE(add(late));
  EXPECT_EQ(counters_.frames_late.value(), 1U);
  expect_identity();
}

}  // namespace
}  // namespace fanlight
