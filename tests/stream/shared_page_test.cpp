// SPDX-License-Identifier: Apache-2.0
// SharedPage: what stands in the file, and how much it takes.
#include "server/stream/shared_page.hpp"

#include <gtest/gtest.h>
#include <openssl/evp.h>

#include <algorithm>
#include <random>

#include "tests/stream/surface_reader.hpp"

namespace fanlight::test {
namespace {

constexpr std::string_view kPage = "<html><!--surfaces--><script></script></html>";

Picture picture_of(std::uint32_t side, float depth_mm, std::int64_t capture_ns) {
  Picture picture = blank_picture(side, side);
  std::fill(picture.depth_mm.begin(), picture.depth_mm.end(), depth_mm);
  picture.stamp.view.mm_per_pixel = 0.2;
  picture.stamp.view.part = {.width = side, .height = side};
  picture.stamp.volume.last_capture_time_ns = capture_ns;
  return picture;
}

v1::SharedSurfaces surfaces_in(const std::string& html) {
  const std::string before = "id=\"surfaces\">";
  const auto from = html.find(before) + before.size();
  const std::string text = html.substr(from, html.find('<', from) - from);
  std::string bytes(text.size(), '\0');
  const int length =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                      reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  const auto padding = std::count(text.end() - 2, text.end(), '=');
  bytes.resize(static_cast<std::size_t>(std::max(length, 0)) - static_cast<std::size_t>(padding));
  v1::SharedSurfaces surfaces;
  EXPECT_TRUE(surfaces.ParseFromString(bytes));
  return surfaces;
}

TEST(SharedPage, HasTheSurfacesTheSceneAndTheTitleAndNoTimeOfDay) {
  Scene scene;
  scene.light.up_mm = 17;
  SharedPage page(kPage, "Face <at> 23 weeks", scene);
  constexpr std::int64_t kCaptureNs = 1'234'567'890'123;
  ASSERT_TRUE(page.add(picture_of(33, 50, kCaptureNs)));
  ASSERT_TRUE(page.add(picture_of(33, 51, kCaptureNs + 400'000'000)));
  const std::string html = page.html();
  EXPECT_EQ(html.substr(0, 6), "<html>");
  EXPECT_TRUE(html.ends_with("<script></script></html>"));
  const v1::SharedSurfaces surfaces = surfaces_in(html);
  EXPECT_EQ(surfaces.title(), "Face <at> 23 weeks");
  EXPECT_EQ(surfaces.scene().light().up_mm(), 17);
  EXPECT_GT(surfaces.fields_size(), 50);
  ASSERT_EQ(surfaces.pictures_size(), 2);
  EXPECT_EQ(surfaces.pictures(0).capture_time_ns(), 0);
  EXPECT_EQ(surfaces.pictures(1).capture_time_ns(), 400'000'000);
  for (int index = 0; index < 2; ++index) {
    const v1::Surface& surface = surfaces.pictures(index).surface();
    EXPECT_NEAR(read_surface(surface).units[100] * surface.depth_unit_mm(), 50 + index, 0.02);
  }
}

TEST(SharedPage, RefusesWhatIsNoSurfaceAndWhatIsTooLarge) {
  SharedPage page(kPage, "", Scene{});
  Picture beside = picture_of(32, 50, 1);
  beside.stamp.view.part.width = 16;
  const auto refused = page.add(beside);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  Picture glass = picture_of(32, 50, 1);
  glass.stamp.view.part.seen_through = true;
  const auto not_drawn = page.add(glass);
  ASSERT_FALSE(not_drawn);
  EXPECT_NE(not_drawn.error().message.find("glass.amount 0"), std::string::npos);
  std::mt19937 random(1);
  Picture rough = picture_of(1024, 50, 1);
  for (float& depth_mm : rough.depth_mm) depth_mm += static_cast<float>(random() % 1000) / 10;
  SharedPage large(kPage, "", Scene{});
  EXPECT_TRUE(large.add(rough));
  const auto too_large = large.add(rough);
  ASSERT_FALSE(too_large);
  EXPECT_EQ(too_large.error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace fanlight::test
