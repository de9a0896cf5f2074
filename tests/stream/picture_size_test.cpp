// SPDX-License-Identifier: Apache-2.0
// Pictures in other sizes than they were rendered in: what the hub asks for, what it sends, how they are
// reduced.
#include <optional>
#include <utility>
#include <vector>

#include "server/codec/reduced_picture.hpp"
#include "server/stream/picture_message.hpp"
#include "tests/stream/picture_hub_rig.hpp"

namespace fanlight::test {
namespace {

/// A hub whose usual pictures have 2 x 2 pixels, and that reports what is asked for.
class SizedHubTest : public PictureHubTest {
 protected:
  WantedSizes wanted_;
  int reports_ = 0;
  PictureHub::Config sized_config() {
    PictureHub::Config config = this->config();
    config.usual_size = PictureSize{2, 2};
    config.wanted_sizes = [this](const WantedSizes& wanted) {
      wanted_ = wanted;
      ++reports_;
    };
    return config;
  }
  PictureHub sized_{counters_, sized_config()};

  /// Of 4 x 4 pixels.
  static Picture fine() {
    Picture picture = blank_picture(4, 4);
    picture.stamp.picture_id = picture.stamp.surface_id = 1;
    picture.stamp.view = {
        .mm_per_pixel = 1, .middle_column = 1.5, .middle_row = 1.5, .part = {.width = 4, .height = 4}};
    for (std::size_t pixel = 0; pixel < picture.depth_mm.size(); ++pixel)
      picture.depth_mm[pixel] = static_cast<float>(pixel);
    return picture;
  }
  static v1::Picture sent_to(const SpySubscriber& subscriber) {
    v1::ServerMessage message;
    EXPECT_TRUE(message.ParseFromString(*subscriber.offers.back().message));
    return message.picture();
  }
};

TEST_F(SizedHubTest, ReportsTheLargestSizeThatIsAskedFor) {
  SpySubscriber usual(1);
  SpySubscriber small(2, {.most_width = 1});
  SpySubscriber wide(3, {.most_width = 6});
  SpySubscriber surface(4, {.codec = StreamSettings::Codec::kSurface, .most_width = 9, .most_height = 4});
  sized_.add(usual);
  sized_.add(small);
  EXPECT_EQ(reports_, 0);
  sized_.add(surface);
  EXPECT_EQ(wanted_.of_surfaces, (PictureSize{4, 4})) << "the proportions are those of the picture";
  EXPECT_EQ(wanted_.of_pictures, std::nullopt);
  sized_.add(wide);
  EXPECT_EQ(wanted_.of_pictures, (PictureSize{6, 6}));
  sized_.remove(wide);
  EXPECT_EQ(wanted_.of_pictures, std::nullopt);
  surface.set_settings({.codec = StreamSettings::Codec::kSurface});
  sized_.resync(surface);
  EXPECT_EQ(wanted_, WantedSizes());
  EXPECT_EQ(reports_, 4);
}

TEST_F(SizedHubTest, ADisplayGetsTheSizeThatItHasAskedFor) {
  SpySubscriber usual(1);
  SpySubscriber large(2, {.most_width = 3});
  SpySubscriber surface(3, {.codec = StreamSettings::Codec::kSurface});
  for (SpySubscriber* each : {&usual, &large, &surface}) sized_.add(*each);
  const Picture picture = fine();
  sized_.show(picture);
  EXPECT_EQ(sent_to(usual).width(), 2U);
  EXPECT_EQ(sent_to(large).width(), 3U);
  EXPECT_EQ(sent_to(surface).width(), 4U);
  EXPECT_EQ(sent_to(surface).surface().width(), 4U);
  // Views are of the usual size, but beside a surface.
  for (const SpySubscriber* each : {&usual, &large}) {
    EXPECT_EQ(sent_to(*each).view().mm_per_pixel(), 2);
    EXPECT_EQ(sent_to(*each).view().middle_column(), 0.5);
  }
  EXPECT_EQ(sent_to(surface).view().mm_per_pixel(), 1);
  EXPECT_EQ(sent_to(surface).view().middle_column(), 1.5);
}

TEST_F(SizedHubTest, AModeWithoutASurfaceHasTheUsualView) {
  SpySubscriber surface(1, {.codec = StreamSettings::Codec::kSurface});
  sized_.add(surface);
  Picture picture = fine();
  picture.stamp.view.part = {};
  sized_.show(picture);
  EXPECT_FALSE(sent_to(surface).has_surface());
  EXPECT_FALSE(sent_to(surface).jpeg().empty());
  EXPECT_EQ(sent_to(surface).view().mm_per_pixel(), 2);
}

TEST(DepthAtPixels, CountsInAnySize) {
  Picture picture = blank_picture(4, 4);
  picture.stamp.view = {.right = {1, 0, 0},
                        .down = {0, 0, -1},
                        .forward = {0, 1, 0},
                        .mm_per_pixel = 0.5,
                        .middle_column = 1.5,
                        .middle_row = 1.5};
  for (std::size_t pixel = 0; pixel < picture.depth_mm.size(); ++pixel)
    picture.depth_mm[pixel] = static_cast<float>(10 + pixel);
  const auto point = [&](PictureSize counted, std::uint32_t column, std::uint32_t row) {
    return point_at(picture, counted, column, row);
  };
  EXPECT_EQ(point({4, 4}, 3, 1).depth_mm(), 17);
  EXPECT_EQ(point({4, 4}, 3, 1).x_mm(), 0.75);
  EXPECT_EQ(point({4, 4}, 3, 1).z_mm(), 0.25);
  for (const auto& [column, row] : {std::pair(6U, 2U), std::pair(7U, 3U)}) {
    EXPECT_EQ(point({8, 8}, column, row).depth_mm(), 17);
    EXPECT_EQ(point({8, 8}, column, row).x_mm(), 0.75);
  }
  EXPECT_EQ(point({2, 2}, 1, 0).depth_mm(), 17) << "the pixel at the centre of the larger one";
  EXPECT_FALSE(point({8, 8}, 8, 0).surface());
  EXPECT_FALSE(point({2, 2}, 0, 2).surface());
}

TEST(ReducedPicture, TakesTheDepthAtTheMiddleOfItsPixels) {
  Picture picture = blank_picture(6, 6);
  picture.stamp.view = {.mm_per_pixel = 1,
                        .middle_column = 2.5,
                        .middle_row = 2.5,
                        .part = {.left = 3, .width = 3, .height = 6}};
  for (std::size_t pixel = 0; pixel < picture.depth_mm.size(); ++pixel) {
    picture.depth_mm[pixel] = static_cast<float>(pixel);
    picture.certainty[pixel] = static_cast<std::uint8_t>(pixel);
    picture.rgba[4 * pixel] = pixel % 6 < 3 ? 200 : 100;
  }
  const Picture small = reduced(picture, {2, 2});
  EXPECT_EQ(small.depth_mm, (std::vector<float>{7, 10, 25, 28}));
  EXPECT_EQ(small.certainty, (std::vector<std::uint8_t>{7, 10, 25, 28}));
  EXPECT_EQ(small.rgba[0], 200);
  EXPECT_EQ(small.rgba[4], 100);
  EXPECT_EQ(small.stamp.view.mm_per_pixel, 3);
  EXPECT_EQ(small.stamp.view.middle_column, 0.5);
  EXPECT_EQ(small.stamp.view.part, (SurfacePart{.left = 1, .width = 1, .height = 2}));
  EXPECT_EQ(reduced_depths(picture, {6, 6}), picture.depth_mm);
}

}  // namespace
}  // namespace fanlight::test
