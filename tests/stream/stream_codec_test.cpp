// SPDX-License-Identifier: Apache-2.0
// Streams over real sockets: the settings that a session asks for, shared encodings and depth maps.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include "tests/stream/h264_reader.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

v1::StreamReply ask(TestDisplay& client, const v1::StreamRequest& request) {
  v1::ClientMessage message;
  *message.mutable_stream() = request;
  client.send(message);
  return client.next(Body::kStreamReply).stream_reply();
}

TEST(Stream, GivesEachSessionItsCodecAndSize) {
  ServerFixture fixture;
  TestDisplay png(fixture.endpoint());
  TestDisplay h264(fixture.endpoint());
  TestDisplay small(fixture.endpoint());
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::PNG);
  EXPECT_EQ(ask(png, request).in_force().codec(), v1::StreamRequest::PNG);
  request.set_codec(v1::StreamRequest::H264);
  EXPECT_EQ(ask(h264, request).in_force().bit_rate_kbps(), 4000U);
  request.set_codec(v1::StreamRequest::JPEG);
  request.set_width(32);
  ask(small, request);
  fixture.show(1, 128);
  EXPECT_EQ(png.next(Body::kPicture).picture().png().substr(1, 3), "PNG");
  const auto picture = h264.next(Body::kPicture).picture();
  EXPECT_TRUE(picture.key_picture());
  EXPECT_EQ(picture.h264().substr(0, 4), std::string("\0\0\0\1", 4));
  EXPECT_EQ(small.next(Body::kPicture).picture().width(), 32U);
  request.set_width(1);
  EXPECT_TRUE(ask(small, request).has_refused());
}

TEST(Stream, SharesOneEncodingAmongEqualSettings) {
  ServerFixture fixture;
  std::vector<std::unique_ptr<TestDisplay>> clients;
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::PNG);
  for (int count = 0; count < 10; ++count) {
    clients.push_back(std::make_unique<TestDisplay>(fixture.endpoint()));
    request.set_rate_hz(count % 2 == 0 ? 0 : 200);
    ask(*clients.back(), request);
  }
  const auto before = fixture.counters().pictures_encoded.value();
  fixture.show(1, 128);
  for (const auto& client : clients) client->next(Body::kPicture);
  EXPECT_EQ(fixture.counters().pictures_encoded.value(), before + 1);
}

TEST(Stream, ALateSubscriberOfAnH264StreamBeginsWithAKeyPicture) {
  ServerFixture fixture;
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::H264);
  TestDisplay first(fixture.endpoint());
  ask(first, request);
  H264Reader first_reader;
  H264Reader second_reader;
  const auto luma = [](H264Reader& reader, const v1::Picture& picture) {
    return reader.luma({reinterpret_cast<const std::uint8_t*>(picture.h264().data()), picture.h264().size()});
  };
  for (std::uint64_t id = 1; id <= 3; ++id) {
    fixture.show(id, static_cast<std::uint8_t>(60 * id));
    EXPECT_FALSE(luma(first_reader, first.next(Body::kPicture).picture()).empty());
  }
  TestDisplay second(fixture.endpoint());
  second.next(Body::kPicture);  // a JPEG, before its stream request
  ask(second, request);
  const auto begun = second.next(Body::kPicture).picture();
  EXPECT_TRUE(begun.key_picture());
  EXPECT_EQ(begun.picture_id(), 3U);
  EXPECT_FALSE(luma(second_reader, begun).empty());
  EXPECT_FALSE(luma(first_reader, first.next(Body::kPicture).picture()).empty())
      << "both displays receive the key picture";
  fixture.show(4, 10);
  const Bytes seen = luma(first_reader, first.next(Body::kPicture).picture());
  EXPECT_EQ(luma(second_reader, second.next(Body::kPicture).picture()), seen);
  EXPECT_FALSE(seen.empty());
}

TEST(Stream, RepeatedStreamChangesCostTheOthersNothing) {
  ServerFixture fixture;
  TestDisplay victim(fixture.endpoint());
  TestDisplay asker(fixture.endpoint());
  v1::StreamRequest request;
  request.set_codec(v1::StreamRequest::H264);
  ask(victim, request);
  fixture.show(1, 50);
  victim.next(Body::kPicture);
  const auto before = fixture.counters().pictures_encoded.value();
  int refused = 0;
  for (int round = 0; round < 100; ++round) {
    request.set_codec(round % 2 == 0 ? v1::StreamRequest::H264 : v1::StreamRequest::PNG);
    refused += ask(asker, request).has_refused() ? 1 : 0;
    ask(asker, request);
  }
  EXPECT_GT(refused, 40);
  EXPECT_LT(fixture.counters().pictures_encoded.value() - before, 20U);
}

TEST(Stream, LimitsTheEncodingsAtATime) {
  ServerFixture fixture;
  fixture.show(1, 50);
  std::vector<std::unique_ptr<TestDisplay>> clients;
  int refused = 0;
  for (std::uint32_t quality = 1; quality <= 30; ++quality) {
    clients.push_back(std::make_unique<TestDisplay>(fixture.endpoint()));
    v1::StreamRequest request;
    request.set_quality(quality);
    refused += ask(*clients.back(), request).has_refused() ? 1 : 0;
  }
  EXPECT_GT(refused, 10);
  EXPECT_LT(refused, 20);
  fixture.show(2, 60);
  for (const auto& client : clients) {
    while (client->next(Body::kPicture).picture().picture_id() != 2) {
    }
  }
}

TEST(Stream, MessagesBeyondTheBudgetWaitForTheNextSecond) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  v1::ClientMessage message;
  message.mutable_clock_request()->set_client_time_ms(1);
  constexpr int kMessages = 1200;
  std::jthread writer([&] {
    for (int sent = 0; sent < kMessages; ++sent) client.send(message);
  });
  for (int answered = 0; answered < kMessages; ++answered) client.next(Body::kClockReply);
}

TEST(Stream, AnswersDepthsAndTheirPositions) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  v1::ClientMessage question;
  question.mutable_depth()->set_request_id(3);
  for (const auto& [column, row] : {std::pair(10U, 20U), std::pair(11U, 20U), std::pair(9999U, 1U)}) {
    auto& pixel = *question.mutable_depth()->add_pixels();
    pixel.set_column(column);
    pixel.set_row(row);
  }
  client.send(question);
  EXPECT_TRUE(client.next(Body::kDepthReply).depth_reply().has_refused()) << "before the first picture";
  fixture.show_depths(7, [](std::uint32_t column, std::uint32_t row) {
    return column == 11 ? -1.0F : 50.0F + static_cast<float>(row);
  });
  v1::StreamRequest request;
  request.set_with_depth(true);
  ask(client, request);
  v1::Picture picture;
  while (picture.depth().empty()) picture = client.next(Body::kPicture).picture();
  std::vector<std::uint16_t> units(std::size_t{ServerFixture::kWidth} * ServerFixture::kHeight);
  uLongf bytes = units.size() * 2;
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(units.data()), &bytes,
                       reinterpret_cast<const Bytef*>(picture.depth().data()), picture.depth().size()),
            Z_OK);
  EXPECT_EQ(bytes, units.size() * 2);
  EXPECT_NEAR(units[20 * ServerFixture::kWidth + 10] * picture.depth_unit_mm(), 70, 0.01);
  EXPECT_EQ(units[20 * ServerFixture::kWidth + 11], 65535);

  client.send(question);
  const auto reply = client.next(Body::kDepthReply).depth_reply();
  EXPECT_EQ(reply.picture_id(), 7U);
  ASSERT_EQ(reply.points_size(), 3);
  EXPECT_NEAR(reply.points(0).depth_mm(), 70, 1e-6);
  // The view of show_depths(): half a millimetre a pixel from (5, 6) on, looking along y.
  EXPECT_NEAR(reply.points(0).x_mm(), 0.5 * (10 - 5), 1e-6);
  EXPECT_NEAR(reply.points(0).y_mm(), 70, 1e-6);
  EXPECT_NEAR(reply.points(0).z_mm(), -0.5 * (20 - 6), 1e-6);
  EXPECT_FALSE(reply.points(1).surface());
  EXPECT_FALSE(reply.points(2).surface());
  for (int pixel = 0; pixel < 2000; ++pixel) question.mutable_depth()->add_pixels();
  client.send(question);
  EXPECT_TRUE(client.next(Body::kDepthReply).depth_reply().has_refused());
}

}  // namespace
}  // namespace fanlight::test
