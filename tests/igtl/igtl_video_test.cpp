// SPDX-License-Identifier: Apache-2.0
// The video of the OpenIGTLink server: H.264 that a decoder reads, in its place.
#include "server/igtl/igtl_video.hpp"

#include "proto/igtl/big_endian.hpp"
#include "proto/igtl/video_body.hpp"
#include "server/igtl/picture_messages.hpp"
#include "tests/igtl/igtl_server_rig.hpp"
#include "tests/stream/h264_reader.hpp"

namespace fanlight::test {
namespace igtl_video_tests {

std::uint16_t number_at(std::span<const std::uint8_t> content, std::size_t at) {
  return igtl::big_endian<std::uint16_t>(content.subspan(at));
}
bool is_key(std::span<const std::uint8_t> content) {
  return number_at(content, 7) == 1;
}
float float_at(std::span<const std::uint8_t> content, std::size_t at) {
  return std::bit_cast<float>(igtl::big_endian<std::uint32_t>(content.subspan(at)));
}

/// The middle of the decoded picture's luma; -1: it could not be decoded.
int grey_of(H264Reader& reader, std::span<const std::uint8_t> content) {
  const auto luma = reader.luma(content.subspan(igtl::kVideoHeaderBytes));
  return luma.empty() ? -1 : luma[luma.size() / 2];
}

Picture grey_picture(std::uint32_t width, std::uint32_t height, std::uint8_t grey) {
  Picture picture = blank_picture(width, height);
  picture.stamp.view = {.right = {1, 0, 0}, .down = {0, 0, -1}, .forward = {0, 1, 0}, .mm_per_pixel = 0.5};
  std::ranges::fill(picture.rgba, grey);
  return picture;
}

TEST(IgtlVideo, IsDecodedPictureByPicture) {
  IgtlVideo video;
  H264Reader reader;
  for (int i = 0; i < 4; ++i) {
    const auto content = video.write(grey_picture(64, 48, static_cast<std::uint8_t>(60 + 30 * i)), i == 2);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->key, i == 0 || i == 2);
    EXPECT_EQ(is_key(content->bytes), content->key);
    // Luma of ITU-R BT.601: 16 to 235.
    EXPECT_NEAR(grey_of(reader, content->bytes), 16 + (60 + 30 * i) * 219 / 255, 3);
  }
}

TEST(IgtlVideo, OfAnOddSizeCoversTheSamePlace) {
  IgtlVideo video;
  const Picture picture = grey_picture(65, 49, 100);
  const auto content = video.write(picture, true);
  ASSERT_TRUE(content);
  EXPECT_EQ(number_at(content->bytes, 10), 64);
  EXPECT_EQ(number_at(content->bytes, 12), 48);
  // The centre of the picture stays, and so does its width.
  EXPECT_NEAR(float_at(content->bytes, 16) * 64, 65 * 0.5, 1e-4);
  EXPECT_NEAR(float_at(content->bytes, 16 + 9 * 4), 32 * 0.5, 1e-4);
  EXPECT_NEAR(float_at(content->bytes, 16 + 11 * 4), -24 * 0.5, 1e-4);
}

TEST(IgtlVideo, ReachesEachClientFromAKeyPictureOn) {
  ServerFixture server(with_igtl());
  TestClient first(server.igtl_port());
  ASSERT_TRUE(first.ask("STT_VIDEO", ""));
  ASSERT_TRUE(first.next_of("RTS_VIDEO"));
  H264Reader of_first;
  std::vector<std::uint8_t> sent;
  for (std::uint64_t id = 1; id <= 3; ++id) {
    server.show(id, static_cast<std::uint8_t>(50 * id));
    const auto message = first.next_of("VIDEO");
    ASSERT_TRUE(message);
    EXPECT_EQ(message->device(), "Video_Transducer");
    EXPECT_EQ(is_key(message->opened().content), id == 1);
    EXPECT_NEAR(grey_of(of_first, message->opened().content), 16 + 50 * static_cast<int>(id) * 219 / 255, 3);
  }
  // The picture does not change: a new client gets it all the same, and the first one loses nothing.
  TestClient second(server.igtl_port());
  ASSERT_TRUE(second.ask("STT_VIDEO", "Video_Transducer", igtl::HeadVersion::kTwo));
  H264Reader of_second;
  const auto begin = second.next_of("VIDEO");
  ASSERT_TRUE(begin);
  EXPECT_TRUE(is_key(begin->opened().content));
  EXPECT_EQ(begin->opened().metadata.find("FanlightPicture"), "3");
  EXPECT_NEAR(grey_of(of_second, begin->opened().content), 16 + 150 * 219 / 255, 3);
  ASSERT_TRUE(first.next_of("VIDEO"));
  server.show(4, 220);
  const auto to_first = first.next_of("VIDEO");
  const auto to_second = second.next_of("VIDEO");
  ASSERT_TRUE(to_first && to_second);
  EXPECT_FALSE(is_key(to_first->opened().content));
  EXPECT_NEAR(grey_of(of_second, to_second->opened().content), 16 + 220 * 219 / 255, 3);
}

TEST(IgtlVideo, RestartsForAClientThatStopsAndStartsOrChangesTheVersion) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  ASSERT_TRUE(client.ask("STT_VIDEO", ""));
  server.show(1, 100);
  ASSERT_TRUE(client.next_of("VIDEO"));
  ASSERT_TRUE(client.ask("STP_VIDEO", ""));
  ASSERT_TRUE(client.ask("STT_VIDEO", ""));
  const auto again = client.next_of("VIDEO");
  ASSERT_TRUE(again) << "the picture does not change";
  EXPECT_TRUE(is_key(again->opened().content));
  ASSERT_TRUE(client.ask("GET_STATUS", "", igtl::HeadVersion::kTwo));
  ASSERT_TRUE(client.next_of("STATUS"));
  server.show(2, 120);
  const auto newer = client.next_of("VIDEO");
  ASSERT_TRUE(newer);
  EXPECT_EQ(newer->head.version, 2U);
  EXPECT_TRUE(is_key(newer->opened().content)) << "the one before may have come in the other version";
}

TEST(IgtlVideo, OfAnotherCodecIsRefused) {
  ServerFixture server(with_igtl());
  TestClient client(server.igtl_port());
  for (const auto& [codec, refused] : {std::pair{"VP90", 1}, std::pair{"H264", 0}}) {
    auto& bytes = client.writer().begin({.type = "STT_VIDEO", .device = ""});
    bytes.insert(bytes.end(), codec, codec + 4);
    bytes.insert(bytes.end(), 4, 0);  // as often as possible
    ASSERT_TRUE(client.send(client.writer().finish()));
    const auto answer = client.next_of("RTS_VIDEO");
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->opened().content[0], refused) << codec;
  }
}

}  // namespace igtl_video_tests
}  // namespace fanlight::test
