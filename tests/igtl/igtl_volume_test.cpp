// SPDX-License-Identifier: Apache-2.0
// The volume on show as a 3D IMAGE, with the test in the render thread's place.
#include <cmath>

#include "acquisition/convert/grid_volume.hpp"
#include "proto/igtl/image_body.hpp"
#include "tests/igtl/igtl_server_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test {
namespace igtl_volume_tests {

constexpr FanGeometry kFan{.columns = 21,
                           .rows = 31,
                           .pixel_width_mm = 1,
                           .pixel_height_mm = 1,
                           .face_column = 10,
                           .motor_radius_mm = 20};

/// Its grey tells the position: 2 a millimetre to the side, from 100 in the middle.
Volume fan_volume(std::uint64_t id) {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 13; ++frame) angles_rad.push_back(radians(-18 + 3 * frame));
  Volume volume = made_volume(kFan, angles_rad, [](const Point& at) { return 100 + 2 * at.x_mm; });
  volume.stamp().volume_id = id;
  return volume;
}

PictureStamp picture_of(std::uint64_t picture_id, std::uint64_t volume_id) {
  return {.picture_id = picture_id, .volume = {.volume_id = volume_id}};
}

TEST(IgtlVolume, IsOnAGridOfCubesInItsPlace) {
  ServerFixture server(with_igtl());
  const Volume volume = fan_volume(7);
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STT_IMAGE", "Volume_Transducer", igtl::HeadVersion::kTwo));
  ASSERT_TRUE(client.next_of("RTS_IMAGE"));
  server.show(picture_of(1, 7), 90);
  server.answer_volume_order(&volume);  // it has no memory yet, and learns how much it needs
  server.answer_volume_order(&volume);
  const auto message = client.next_of("IMAGE", "Volume_Transducer");
  ASSERT_TRUE(message);
  EXPECT_EQ(message->opened().metadata.find("FanlightVolume"), "7");
  const auto image = igtl::parse_image(message->opened().content);
  ASSERT_TRUE(image);
  const auto grid = scan_converted(volume, 2, [](double) { return true; });
  ASSERT_TRUE(grid);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(image->body.size[axis], grid->size[axis]);
    EXPECT_NEAR(image->body.pose.first_mm[axis], grid->origin_mm[axis], 1e-4);
  }
  EXPECT_NEAR(image->body.pose.i_mm[0], 2, 1e-6);
  EXPECT_NEAR(image->body.pose.j_mm[1], 2, 1e-6);
  EXPECT_NEAR(image->body.pose.k_mm[2], 2, 1e-6);
  ASSERT_TRUE(std::ranges::equal(image->pixels, grid->voxels));
  // The voxel 4 mm to the side, 20 mm deep and in the middle has the grey of its place.
  const auto index = [&](std::size_t axis, double mm) {
    return static_cast<std::size_t>(std::lround((mm - image->body.pose.first_mm[axis]) / 2));
  };
  const std::size_t voxel =
      (index(2, 0) * image->body.size[1] + index(1, 20)) * image->body.size[0] + index(0, 4);
  EXPECT_NEAR(image->pixels[voxel], 108, 1);
}

TEST(IgtlVolume, IsSentOnceForEachVolume) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STT_IMAGE", "Volume_Transducer"));
  ASSERT_TRUE(client.next_of("RTS_IMAGE"));
  server.show(picture_of(1, 7), 90);
  const Volume first = fan_volume(7);
  server.answer_volume_order(&first);
  server.answer_volume_order(&first);
  ASSERT_TRUE(client.next_of("IMAGE"));
  server.show(picture_of(3, 7), 92);
  while (const auto message = client.next(300)) EXPECT_NE(message->type(), "IMAGE");
  server.show(picture_of(4, 8), 93);
  const Volume second = fan_volume(8);
  server.answer_volume_order(&second);
  EXPECT_TRUE(client.next_of("IMAGE"));
  EXPECT_EQ(server.counters().igtl_messages_offered.value(), 2U);
}

TEST(IgtlVolume, ThatIsNewerThanThePictureIsNotSentAgainWithItsOwn) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STT_IMAGE", "Volume_Transducer", igtl::HeadVersion::kTwo));
  ASSERT_TRUE(client.next_of("RTS_IMAGE"));
  const Volume newer = fan_volume(8);
  server.show(picture_of(1, 7), 90);
  server.answer_volume_order(&newer);
  server.answer_volume_order(&newer);
  const auto message = client.next_of("IMAGE");
  ASSERT_TRUE(message);
  EXPECT_EQ(message->opened().metadata.find("FanlightVolume"), "8");
  server.show(picture_of(2, 7), 91);
  server.show(picture_of(3, 8), 92);
  while (const auto other = client.next(300)) EXPECT_NE(other->type(), "IMAGE");
  ASSERT_TRUE(client.ask("STT_IMAGE", "Volume_Transducer", igtl::HeadVersion::kTwo));
  server.answer_volume_order(&newer);
  EXPECT_TRUE(client.next_of("IMAGE")) << "who asks again gets it again";
}

TEST(IgtlVolume, ThatIsNotThereIsAnsweredByAnEmptyMessage) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STP_IMAGE", ""));
  server.show(picture_of(1, 7), 90);
  ASSERT_TRUE(client.ask("GET_IMAGE", "Volume_Transducer"));
  server.answer_volume_order(nullptr);
  const auto message = client.next_of("IMAGE", "Volume_Transducer");
  ASSERT_TRUE(message);
  EXPECT_TRUE(message->opened().content.empty());
}

TEST(IgtlVolume, ThatIsTooFineIsRefusedAndTheRestGoesOn) {
  StreamServer::Config config = with_igtl();
  config.igtl->spacing_mm = 0.05;  // 600 million voxels
  ServerFixture server(config);
  FanGeometry geometry = kFan;
  geometry.pixel_width_mm = geometry.pixel_height_mm = 2;
  const std::vector<double> angles_rad = {-0.3, 0, 0.3};
  const Volume volume = made_volume(geometry, angles_rad, [](const Point& /*at*/) { return 100; });
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STT_IMAGE", "Volume_Transducer"));
  ASSERT_TRUE(client.ask("STT_IMAGE", "Picture_Transducer"));
  ASSERT_TRUE(client.next_of("RTS_IMAGE"));
  server.show(picture_of(1, 1), 90);
  server.answer_volume_order(&volume);
  server.answer_volume_order(&volume);
  for (std::uint64_t i = 2; i < 5; ++i) {
    const auto message = client.next_of("IMAGE");
    ASSERT_TRUE(message);
    EXPECT_EQ(message->device(), "Picture_Transducer");
    server.show(picture_of(i, i), 90);
  }
  EXPECT_FALSE(server.has_volume_order()) << "it is not tried again at once";
}

}  // namespace igtl_volume_tests
}  // namespace fanlight::test
