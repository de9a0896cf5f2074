// SPDX-License-Identifier: Apache-2.0
// Scan lines of a real curved array, compared with images that independent software computed from them. The
// images agree only if our reader orients the lines correctly and our geometry is correct.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/support/scan_conversion_oracle.hpp"

namespace fanlight {
namespace {

/// Grey level between the pixels of a frame, bilinear; nullopt outside.
std::optional<double> grey_at(std::span<const std::uint8_t> frame, const FanGeometry& geometry,
                              FramePlace at) {
  const double left = std::floor(at.column);
  const double above = std::floor(at.row);
  if (!(left >= 0 && above >= 0 && left < geometry.columns - 1 && above < geometry.rows - 1)) return {};
  const std::size_t first =
      static_cast<std::size_t>(above) * geometry.columns + static_cast<std::size_t>(left);
  const auto across = [&](std::size_t pixel) {
    return std::lerp(double{1} * frame[pixel], double{1} * frame[pixel + 1], at.column - left);
  };
  return std::lerp(across(first), across(first + geometry.columns), at.row - above);
}

/// Correlation of the reference image with our conversion, inside the fan. `mirror`: -1 swaps left and right
/// of ours.
test::Correlation correlation(const FrameSequence& lines, const FrameSequence& twin, std::size_t frame,
                              double mirror) {
  const FanGeometry geometry = test::oracle_probe(lines);
  test::Correlation found;
  for (std::uint32_t row = 0; row < twin.rows; ++row) {
    for (std::uint32_t column = 0; column < twin.columns; ++column) {
      PlanePoint at = test::oracle_point(geometry, column, row);
      at.x_mm *= mirror;
      const auto ours = grey_at(lines.frame_pixels(frame), geometry, geometry.frame_place(at));
      if (ours) found.add(*ours, twin.frame_pixels(frame)[row * twin.columns + column]);
    }
  }
  return found;
}

TEST(ScanConversionOracle, OurConversionOfEachFrameIsItsTwin) {
  if (!test::has_oracle()) {
    GTEST_SKIP() << test::kOracleLines << " and its pictures are not in " << test::data_folder()
                 << "; set FANLIGHT_DATA to their folder";
  }
  const auto [lines, twin] = test::read_oracle();
  ASSERT_EQ(lines.columns, 96U);
  ASSERT_EQ(lines.rows, 3640U);
  ASSERT_EQ(lines.frames.size(), twin.frames.size());
  ASSERT_TRUE(check(test::oracle_probe(lines)));

  for (std::size_t frame = 0; frame < lines.frames.size(); ++frame) {
    const test::Correlation ours = correlation(lines, twin, frame, 1);
    const test::Correlation mirrored = correlation(lines, twin, frame, -1);
    fmt::print("frame {}: correlation {:.5f} over {} pixels, mirrored {:.3f}\n", frame, ours.value(),
               ours.count(), mirrored.value());
    EXPECT_GT(ours.count(), 0.5 * twin.columns * twin.rows);
    EXPECT_GE(ours.value(), 0.999) << "frame " << frame;
    EXPECT_LT(mirrored.value(), 0.5) << "frame " << frame;
  }
}

}  // namespace
}  // namespace fanlight
