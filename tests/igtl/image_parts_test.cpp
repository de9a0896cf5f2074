// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/image_parts.hpp"

#include <gtest/gtest.h>

#include "tests/igtl/sent_messages.hpp"

namespace fanlight::test {
namespace image_parts_tests {

using State = ImageParts::State;

/// A part of an image of 4 x 6 pixels.
igtl::ReceivedImage part(std::array<std::uint16_t, 3> offset, std::array<std::uint16_t, 3> size,
                         const Bytes& pixels) {
  igtl::ReceivedImage image;
  image.body.size = {4, 6, 1};
  image.body.part_offset = offset;
  image.body.part_size = size;
  image.pixels = pixels;
  return image;
}

TEST(ImageParts, PutsRowsAndColumnsWhereTheyBelong) {
  ImageParts parts;
  const Bytes ones(8, 1);
  const Bytes twos(8, 2);
  const Bytes threes(8, 3);
  EXPECT_EQ(parts.add(part({0, 0, 0}, {4, 2, 1}, ones)), State::kMore);
  EXPECT_EQ(parts.add(part({2, 2, 0}, {2, 4, 1}, threes)), State::kMore) << "any order";
  EXPECT_EQ(parts.add(part({0, 2, 0}, {2, 4, 1}, twos)), State::kWhole);
  const Bytes expected = {1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3, 2, 2, 3, 3, 2, 2, 3, 3};
  EXPECT_EQ(Bytes(parts.pixels().begin(), parts.pixels().end()), expected);
}

TEST(ImageParts, TellsOfImagesThatAreNotWhole) {
  ImageParts parts;
  const Bytes half(12, 1);
  EXPECT_EQ(parts.add(part({0, 3, 0}, {4, 3, 1}, half)), State::kStray);
  EXPECT_EQ(parts.add(part({0, 0, 0}, {4, 3, 1}, half)), State::kMore);
  EXPECT_EQ(parts.add(part({0, 0, 0}, {4, 3, 1}, half)), State::kCut) << "the next image has begun";
  EXPECT_EQ(parts.add(part({0, 3, 0}, {4, 3, 1}, half)), State::kWhole);
  EXPECT_FALSE(parts.abandon());
  EXPECT_EQ(parts.add(part({0, 0, 0}, {4, 3, 1}, half)), State::kMore);
  igtl::ReceivedImage other = part({0, 3, 0}, {4, 3, 1}, half);
  other.body.size = {4, 7, 1};
  EXPECT_EQ(parts.add(other), State::kCut) << "of an image of another size";
  EXPECT_EQ(parts.add(part({0, 0, 0}, {4, 3, 1}, half)), State::kMore);
  EXPECT_TRUE(parts.abandon());
}

TEST(ImageParts, PartsThatOverlapMakeNoImage) {
  ImageParts parts;
  const Bytes half(12, 1);
  EXPECT_EQ(parts.add(part({0, 0, 0}, {4, 3, 1}, half)), State::kMore);
  // As many pixels as the image has, but its last row is still that of an image before.
  EXPECT_EQ(parts.add(part({0, 2, 0}, {4, 3, 1}, half)), State::kCut);
  EXPECT_EQ(parts.add(part({0, 3, 0}, {4, 3, 1}, half)), State::kStray) << "the image was given up";
  EXPECT_EQ(parts.add(part({0, 0, 0}, {4, 3, 1}, half)), State::kMore);
  EXPECT_EQ(parts.add(part({0, 3, 0}, {4, 3, 1}, half)), State::kWhole);
}

}  // namespace image_parts_tests
}  // namespace fanlight::test
