// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/image_orientation.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace fanlight {
namespace {

// Several tiles and a partial one, in both directions.
constexpr FrameSize kSize = {.columns = 45, .rows = 70};

std::uint8_t grey_at(std::uint32_t column, std::uint32_t row) {
  return static_cast<std::uint8_t>(7 * column + 31 * row + 1);
}

/// Index in the image of a frame's pixel, along an axis with the direction `letter`.
std::uint32_t along(char letter, std::uint32_t column, std::uint32_t row) {
  switch (letter) {
    case 'M':
      return column;
    case 'U':
      return kSize.columns - 1 - column;
    case 'F':
      return row;
    default:
      return kSize.rows - 1 - row;
  }
}

/// The frame as stored in an image with these letters.
std::vector<std::uint8_t> stored(std::string_view letters) {
  const bool lateral_first = letters[0] == 'M' || letters[0] == 'U';
  const std::uint32_t width = lateral_first ? kSize.columns : kSize.rows;
  std::vector<std::uint8_t> image(std::size_t{kSize.columns} * kSize.rows);
  for (std::uint32_t row = 0; row < kSize.rows; ++row) {
    for (std::uint32_t column = 0; column < kSize.columns; ++column) {
      image[along(letters[1], column, row) * width + along(letters[0], column, row)] = grey_at(column, row);
    }
  }
  return image;
}

class OrientedImage : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(InEachWay, OrientedImage,
                         testing::Values("MF", "MN", "UF", "UN", "FM", "FU", "NM", "NU", "MFA", "MFD", "UNA",
                                         "FMA", "FMD", "NUD"),
                         [](const auto& letters) { return std::string(letters.param); });

TEST_P(OrientedImage, BecomesTheSameFrame) {
  const auto orientation = ImageOrientation::from_letters(GetParam());
  ASSERT_TRUE(orientation);
  std::vector<std::uint8_t> frame(std::size_t{kSize.columns} * kSize.rows);
  arrange_frame(stored(GetParam()), *orientation, kSize, frame);
  for (std::uint32_t row = 0; row < kSize.rows; ++row) {
    for (std::uint32_t column = 0; column < kSize.columns; ++column) {
      ASSERT_EQ(frame[row * kSize.columns + column], grey_at(column, row)) << column << ' ' << row;
    }
  }
}

TEST(ImageOrientation, RefusesOtherLetters) {
  for (const char* const letters :
       {"", "M", "MM", "MU", "FN", "XX", "mf", "MFX", "AMF", "MA", "MFAA", "MF "}) {
    EXPECT_FALSE(ImageOrientation::from_letters(letters)) << letters;
  }
}

}  // namespace
}  // namespace fanlight
