// SPDX-License-Identifier: Apache-2.0
// SurfaceCoder: a display reads the depth map that was packed, to half a unit.
#include "server/codec/surface_coder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/stream/surface_reader.hpp"

namespace fanlight::test {
namespace {

Picture picture_of(std::uint32_t width, std::uint32_t height, const SurfacePart& part) {
  Picture picture = blank_picture(width, height);
  std::fill(picture.depth_mm.begin(), picture.depth_mm.end(), -1.F);
  picture.stamp.surface_id = 7;
  picture.stamp.view.mm_per_pixel = 0.24;
  picture.stamp.view.part = part;
  return picture;
}

/// Each block of 2 x 2 pixels with a surface has the certainty of its most certain one.
void expect_certainties(const Picture& picture, const ReadSurface& read) {
  const SurfacePart& part = picture.stamp.view.part;
  std::size_t next = 0;
  for (std::uint32_t block = 0; block < ((part.width + 1) / 2) * ((part.height + 1) / 2); ++block) {
    const std::uint32_t left = block % ((part.width + 1) / 2) * 2;
    const std::uint32_t top = block / ((part.width + 1) / 2) * 2;
    int largest = -1;
    int filled = 0;
    for (std::uint32_t y = top; y < std::min(top + 2, part.height); ++y) {
      for (std::uint32_t x = left; x < std::min(left + 2, part.width); ++x) {
        const std::size_t at = std::size_t{part.top + y} * picture.width + part.left + x;
        if (picture.depth_mm[at] < 0) continue;
        largest = std::max<int>(largest, picture.certainty[at]);
        if (picture.certainty[at] == 0) filled += 1 << (2 * (y - top) + x - left);
      }
    }
    if (largest < 0) continue;
    if (largest > 0 && filled > 0) {
      EXPECT_EQ(read.certainties.at(next++), 128 + filled);
    }
    const int sent = read.certainties.at(next++);
    EXPECT_EQ(sent == 0, largest == 0);
    if (largest == 0) continue;
    EXPECT_NEAR((sent - 1) / 15.0, (largest - 1) / 254.0, 0.5 / 15 + 1e-9);
  }
  EXPECT_EQ(next, read.certainties.size());
}

/// Packs and reads the surface, and compares every pixel of the part.
v1::Surface expect_read(SurfaceCoder& coder, const Picture& picture) {
  v1::Surface surface;
  const auto packed = coder.encode(picture, surface);
  EXPECT_TRUE(packed) << packed.error().message;
  const SurfacePart& part = picture.stamp.view.part;
  EXPECT_EQ(surface.width(), part.width);
  EXPECT_EQ(surface.height(), part.height);
  const double unit_mm = surface.depth_unit_mm();
  const ReadSurface read = read_surface(surface);
  for (std::uint32_t y = 0; y < part.height; ++y) {
    for (std::uint32_t x = 0; x < part.width; ++x) {
      const std::size_t from = std::size_t{part.top + y} * picture.width + part.left + x;
      const int units = read.units[std::size_t{y} * part.width + x];
      if (picture.depth_mm[from] < 0) {
        EXPECT_EQ(units, -1) << x << ", " << y;
        continue;
      }
      EXPECT_NEAR(units * unit_mm, picture.depth_mm[from], 0.501 * unit_mm + 1e-5) << x << ", " << y;
    }
  }
  expect_certainties(picture, read);
  return surface;
}

TEST(SurfaceCoder, PacksAnyMapsAndUsesItsMemoryAgain) {
  SurfaceCoder coder;
  std::mt19937 random(42);
  for (int round = 0; round < 60; ++round) {
    const auto side = [&] { return 1 + static_cast<std::uint32_t>(random() % 70); };
    SurfacePart part{.left = side() % 8, .top = side() % 8, .width = side(), .height = side()};
    Picture picture = picture_of(part.left + part.width + side() % 5, part.top + part.height, part);
    const double share = (round % 5) / 4.0;                             // of pixels with a surface
    const double rough_mm = round % 3 == 0 ? 600 : 0.05 * (round % 7);  // from pixel to pixel
    for (std::size_t at = 0; at < picture.depth_mm.size(); ++at) {
      const bool has = static_cast<double>(random() % 1000) / 1000 < share;
      const double noise = static_cast<double>(random() % 1000) / 1000 * rough_mm;
      picture.depth_mm[at] =
          has ? static_cast<float>(40 + 0.01 * static_cast<double>(at % 90) + noise) : -1.F;
      picture.certainty[at] = static_cast<std::uint8_t>(random() % 256);
    }
    expect_read(coder, picture);
    if (HasFailure()) FAIL() << "round " << round;
  }
}

TEST(SurfaceCoder, PacksNothingAndASmoothBodySmall) {
  SurfaceCoder coder;
  const SurfacePart all{.width = 256, .height = 256};
  Picture picture = picture_of(256, 256, all);
  EXPECT_LT(expect_read(coder, picture).ByteSizeLong(), 200U) << "no surface";
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const double apart = std::hypot(x - 128, y - 128) / 100;
      if (apart < 1)
        picture.depth_mm[256 * y + x] = static_cast<float>(60 - 25 * std::sqrt(1 - apart * apart));
      picture.certainty[256 * y + x] = 255;
    }
  }
  const v1::Surface ball = expect_read(coder, picture);
  EXPECT_LT(ball.ByteSizeLong(), 16'000U) << "4 bits for each pixel of a ball";
  EXPECT_EQ(ball.surface_id(), 7U);
  EXPECT_DOUBLE_EQ(ball.depth_unit_mm(), 0.02);
}

TEST(SurfaceCoder, ChoosesItsStepByThePixelsAndTheDeepestSurface) {
  EXPECT_DOUBLE_EQ(surface_unit_mm({.mm_per_pixel = 0.3}, 100), 0.02);
  EXPECT_DOUBLE_EQ(surface_unit_mm({.mm_per_pixel = 0.12}, 100), 0.01);
  EXPECT_DOUBLE_EQ(surface_unit_mm({.mm_per_pixel = 0.01}, 100), 0.005);
  EXPECT_DOUBLE_EQ(surface_unit_mm({.mm_per_pixel = 0.06, .mm_per_pixel_per_mm = 0.0006}, 100), 0.01);
  // All that lies deeper is sent too, in larger steps.
  EXPECT_DOUBLE_EQ(surface_unit_mm({.mm_per_pixel = 0.3}, 4000), 4000.0 / 65534);
  SurfaceCoder coder;
  Picture picture = picture_of(2, 1, {.width = 2, .height = 1});
  picture.depth_mm = {0.F, 4000.F};
  picture.certainty = {1, 255};
  expect_read(coder, picture);
}

}  // namespace
}  // namespace fanlight::test
