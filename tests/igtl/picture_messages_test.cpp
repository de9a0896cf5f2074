// SPDX-License-Identifier: Apache-2.0
// Where OpenIGTLink puts a picture, its depths and its surface.
#include "server/igtl/picture_messages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "proto/igtl/opened_message.hpp"
#include "proto/igtl/pose_bodies.hpp"
#include "tests/igtl/corpus.hpp"

namespace fanlight::test {
namespace picture_messages_tests {

/// 8 x 6 pixels seen along y from y = -20, with a surface at the depth 10 + column.
Picture picture_of(double mm_per_pixel_per_mm) {
  Picture picture = blank_picture(8, 6);
  picture.stamp.picture_id = 5;
  picture.stamp.view = {.origin_mm = {1, -20, 3},
                        .right = {1, 0, 0},
                        .down = {0, 0, -1},
                        .forward = {0, 1, 0},
                        .mm_per_pixel = 0.5,
                        .mm_per_pixel_per_mm = mm_per_pixel_per_mm,
                        .middle_column = 3.5,
                        .middle_row = 2.5};
  for (std::size_t i = 0; i < picture.depth_mm.size(); ++i) {
    picture.depth_mm[i] = 10 + static_cast<float>(i % 8);
    picture.rgba[4 * i] = 200;
    picture.rgba[4 * i + 1] = static_cast<std::uint8_t>(i);
    picture.rgba[4 * i + 2] = 7;
  }
  return picture;
}

/// The message of a stream in version 2, opened.
igtl::OpenedMessage opened(const IgtlMessage& message) {
  const auto head = igtl::parse_head(std::span(*message).first<igtl::kHeadBytes>());
  return igtl::open_message(*head, std::span(*message).subspan(igtl::kHeadBytes));
}

IgtlMessage message_of(const Picture& picture, IgtlStream stream) {
  IgtlWanted wanted;
  wanted.version_2.set(stream, true);
  return picture_messages(picture, wanted, 1'700'000'000'000'000'000).at(stream).version_2;
}

TEST(PictureMessages, PutThePictureWhereTheSurfaceIs) {
  const Picture picture = picture_of(0);
  const IgtlMessage message = message_of(picture, IgtlStream::kPicture);
  const auto parts = opened(message);
  ASSERT_EQ(parts.state, igtl::OpenedMessage::State::kGood);
  EXPECT_EQ(parts.metadata.find("FanlightPicture"), "5");
  const auto image = igtl::parse_image(parts.content);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->body.components, 3);
  EXPECT_EQ(image->pixels[0], 200);
  EXPECT_EQ(image->pixels[3 * 9 + 1], 9);
  // The middle of the depths 10 to 17 is 14: y = -20 + 14.
  EXPECT_NEAR(image->body.pose.first_mm[0], 1 - 3.5 * 0.5, 1e-6);
  EXPECT_NEAR(image->body.pose.first_mm[1], -6, 1e-6);
  EXPECT_NEAR(image->body.pose.first_mm[2], 3 + 2.5 * 0.5, 1e-6);
  EXPECT_NEAR(image->body.pose.i_mm[0], 0.5, 1e-6);
  EXPECT_NEAR(image->body.pose.j_mm[2], -0.5, 1e-6);
}

TEST(PictureMessages, GiveThePictureTheSizeThatItHasThereInAPerspective) {
  const IgtlMessage message = message_of(picture_of(0.1), IgtlStream::kPicture);
  const auto image = igtl::parse_image(opened(message).content);
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->body.pose.i_mm[0], 0.5 + 14 * 0.1, 1e-6);
  const auto camera = igtl::parse_transform(opened(message_of(picture_of(0.1), IgtlStream::kCamera)).content);
  ASSERT_TRUE(camera);
  EXPECT_NEAR(camera->first_mm[1], -25, 1e-5) << "the rays meet 5 mm before the view plane";
  EXPECT_NEAR(camera->k_mm[1], 1, 1e-6) << "it looks along y";
}

TEST(PictureMessages, TellDepthsInMillimetres) {
  Picture picture = picture_of(0);
  picture.depth_mm[3] = -5;
  const IgtlMessage message = message_of(picture, IgtlStream::kDepth);
  const auto image = igtl::parse_image(opened(message).content);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->body.scalar, igtl::ScalarType::kFloat32);
  float depth_mm = 0;
  std::memcpy(&depth_mm, &image->pixels[4 * 2], 4);
  EXPECT_EQ(depth_mm, 12);
  std::memcpy(&depth_mm, &image->pixels[4 * 3], 4);
  EXPECT_EQ(depth_mm, -1) << "no surface";
}

TEST(PictureMessages, HaveASurfaceOfTrianglesInPlace) {
  Picture picture = picture_of(0);
  for (float& depth_mm : picture.depth_mm) depth_mm = 10;
  const IgtlMessage message = message_of(picture, IgtlStream::kSurface);
  const auto content = opened(message).content;
  const auto number = [&content](std::size_t at) {
    return std::uint32_t{content[at]} << 24 | content[at + 1] << 16 | content[at + 2] << 8 | content[at + 3];
  };
  EXPECT_EQ(number(0), 48U) << "points";
  EXPECT_EQ(number(20), 2U * 7 * 5) << "triangles";
  EXPECT_EQ(number(24), 4U * 4 * 2 * 7 * 5) << "their bytes";
  EXPECT_EQ(number(36), 2U) << "attributes";
  float smallest_y = 1e9F;
  for (std::size_t point = 0; point < 48; ++point) {
    const std::uint32_t bits = number(40 + 12 * point + 4);
    float y = 0;
    std::memcpy(&y, &bits, 4);
    smallest_y = std::min(smallest_y, y);
  }
  EXPECT_EQ(smallest_y, -10);
}

TEST(PictureMessages, AreWrittenForThoseWhoWantThem) {
  IgtlWanted wanted;
  wanted.version_1.set(IgtlStream::kCamera, true);
  auto messages = picture_messages(picture_of(0), wanted, 0);
  EXPECT_NE(messages.at(IgtlStream::kCamera).version_1, nullptr);
  EXPECT_EQ(messages.at(IgtlStream::kCamera).version_2, nullptr);
  EXPECT_EQ(messages.at(IgtlStream::kPicture).version_1, nullptr);
}

TEST(PictureMessages, StandAPictureWithoutASurface) {
  Picture picture = picture_of(0);
  for (float& depth_mm : picture.depth_mm) depth_mm = -1;
  const IgtlMessage message = message_of(picture, IgtlStream::kPicture);
  const auto image = igtl::parse_image(opened(message).content);
  ASSERT_TRUE(image);
  EXPECT_NEAR(image->body.pose.first_mm[1], -20, 1e-6) << "the view plane";
  EXPECT_EQ(opened(message_of(picture, IgtlStream::kSurface)).state, igtl::OpenedMessage::State::kGood);
}

TEST(PictureMessages, HaveASurfaceByteByByte) {
  Picture picture = blank_picture(2, 2);
  picture.stamp.view = {.right = {1, 0, 0}, .down = {0, 0, -1}, .forward = {0, 1, 0}, .mm_per_pixel = 1};
  picture.depth_mm.assign(4, 10);
  for (std::size_t i = 0; i < 4; ++i) {
    picture.rgba[4 * i] = 10;
    picture.rgba[4 * i + 1] = 20;
    picture.rgba[4 * i + 2] = 30;
  }
  IgtlWanted wanted;
  wanted.version_1.set(IgtlStream::kSurface, true);
  const auto message = picture_messages(picture, wanted, kCorpusNs).at(IgtlStream::kSurface).version_1;
  EXPECT_EQ(*message, corpus_message("polydata"));
}

}  // namespace picture_messages_tests
}  // namespace fanlight::test
