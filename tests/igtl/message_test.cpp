// SPDX-License-Identifier: Apache-2.0
// The messages of OpenIGTLink, by their documents: what is written has these bytes, and is read again.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "proto/base/crc64.hpp"
#include "proto/igtl/message_head.hpp"
#include "proto/igtl/opened_message.hpp"
#include "proto/igtl/text_bodies.hpp"
#include "proto/igtl/timestamp.hpp"
#include "tests/igtl/sent_messages.hpp"

namespace fanlight::test {
namespace message_tests {

igtl::MessageHead head_of(const Bytes& message) {
  return *igtl::parse_head(std::span(message).first<igtl::kHeadBytes>());
}

igtl::OpenedMessage opened(const Bytes& message) {
  return igtl::open_message(head_of(message), std::span(message).subspan(igtl::kHeadBytes));
}

Bytes written(const igtl::Envelope& envelope, const Bytes& content) {
  igtl::MessageWriter writer;
  auto& bytes = writer.begin(envelope);
  bytes.insert(bytes.end(), content.begin(), content.end());
  const auto message = writer.finish();
  return {message.begin(), message.end()};
}

std::string text_of(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

TEST(Crc64, IsThatOfEcma182) {
  const std::string digits = "123456789";
  const Bytes bytes(digits.begin(), digits.end());
  EXPECT_EQ(crc64(bytes), 0x6C40DF5F0B497347U);
  EXPECT_EQ(crc64(std::span(bytes).subspan(4), crc64(std::span(bytes).first(4))), crc64(bytes));
  EXPECT_EQ(crc64({}), 0U);
}

TEST(IgtlTimestamp, IsSecondsAndTheirFraction) {
  EXPECT_EQ(igtl::timestamp_of(1'500'000'000), (std::uint64_t{1} << 32) + (std::uint64_t{1} << 31));
  for (const std::uint64_t ns :
       {0UL, 1UL, 999'999'999UL, 1'700'000'000'123'456'789UL, 4'294'967'295'000'000'001UL})
    EXPECT_EQ(igtl::ns_of(igtl::timestamp_of(ns)), ns) << "to the nearest ns";
}

TEST(IgtlMessage, HasAHeadOf58Bytes) {
  const Bytes message =
      written({.type = "STRING", .device = "Title", .timestamp = 0x0102030405060708}, {9, 8, 7});
  ASSERT_EQ(message.size(), 61U);
  EXPECT_EQ(message[0], 0);
  EXPECT_EQ(message[1], 1) << "version 1, most significant byte first";
  EXPECT_EQ(text_of(std::span(message).subspan(2, 12)), std::string("STRING\0\0\0\0\0\0", 12));
  EXPECT_EQ(text_of(std::span(message).subspan(14, 5)), "Title");
  EXPECT_EQ(message[34], 1);
  EXPECT_EQ(message[41], 8);
  EXPECT_EQ(message[49], 3) << "length of the body";
  EXPECT_EQ(head_of(message).crc, crc64(Bytes{9, 8, 7}));
  EXPECT_EQ(head_of(message).device.view(), "Title");
  EXPECT_EQ(text_of(opened(message).content), "\x09\x08\x07");
}

TEST(IgtlMessage, OfVersion2HasMetadataAndAnId) {
  const Items items = {{"MotorAngleDeg", "-12.5"}, {"empty", ""}};
  const auto views = views_of(items);
  const Bytes message =
      written({.type = "IMAGE", .version = igtl::HeadVersion::kTwo, .message_id = 77, .metadata = views},
              {1, 2, 3, 4});
  const auto parts = opened(message);
  ASSERT_EQ(parts.state, igtl::OpenedMessage::State::kGood);
  EXPECT_EQ(parts.message_id, 77U);
  EXPECT_EQ(text_of(parts.content), "\x01\x02\x03\x04");
  EXPECT_EQ(parts.metadata.size(), 2U);
  EXPECT_EQ(parts.metadata.find("MotorAngleDeg"), "-12.5");
  EXPECT_EQ(parts.metadata.find("empty"), "");
  EXPECT_EQ(parts.metadata.find("Motor"), std::nullopt);
  // 12 bytes of extended header, 4 of content, 2 + 2 * 8 of index, 13 + 5 + 5 of texts.
  EXPECT_EQ(message.size() - igtl::kHeadBytes, 12U + 4 + 18 + 23);
  EXPECT_EQ(message[igtl::kHeadBytes + 1], 12);
  EXPECT_EQ(message[igtl::kHeadBytes + 3], 18);
  EXPECT_EQ(message[igtl::kHeadBytes + 7], 23);
}

TEST(IgtlMessage, WithAWrongChecksumOrLengthsIsNoMessage) {
  const Items items = {{"a", "b"}};
  const auto views = views_of(items);
  const Bytes good =
      written({.type = "IMAGE", .version = igtl::HeadVersion::kTwo, .metadata = views}, {1, 2, 3, 4});
  for (std::size_t at = igtl::kHeadBytes; at < good.size(); ++at) {
    Bytes damaged = good;
    damaged[at] ^= 0x10;
    EXPECT_EQ(opened(damaged).state, igtl::OpenedMessage::State::kDamaged) << at;
    // With a checksum that fits, each length is still wrong.
    const bool length = at < igtl::kHeadBytes + 8;
    if (!length) continue;
    const auto body = std::span(damaged).subspan(igtl::kHeadBytes);
    igtl::MessageHead head = head_of(damaged);
    head.crc = crc64(body);
    EXPECT_EQ(igtl::open_message(head, body).state, igtl::OpenedMessage::State::kMalformed) << at;
  }
}

TEST(IgtlHead, IsKnownByVersionAndType) {
  Bytes head = written({.type = "IMAGE"}, {});
  const auto parsed = [&head] { return igtl::parse_head(std::span(head).first<igtl::kHeadBytes>()); };
  EXPECT_TRUE(parsed());
  head[1] = 3;
  EXPECT_TRUE(parsed());
  head[1] = 4;
  EXPECT_FALSE(parsed());
  head[1] = 0;
  EXPECT_FALSE(parsed());
  head[1] = 1;
  head[3] = 0x07;
  EXPECT_FALSE(parsed());
  head[2] = 0;
  EXPECT_FALSE(parsed()) << "no type";
}

TEST(IgtlHead, NamesQueries) {
  EXPECT_EQ(igtl::query_of("STT_TDATA").query, igtl::Query::kStart);
  EXPECT_EQ(igtl::query_of("STT_TDATA").type, "TDATA");
  EXPECT_EQ(igtl::query_of("GET_CAPABIL").query, igtl::Query::kGet);
  EXPECT_EQ(igtl::query_of("RTS_COMMAND").query, igtl::Query::kReply);
  EXPECT_EQ(igtl::query_of("STATUS").query, igtl::Query::kNone);
}

TEST(IgtlImage, KeepsItsPlaceAndPixels) {
  SentImage sent;
  sent.pose = {.i_mm = {0.5, 0, 0}, .j_mm = {0, 0.25, 0.125}, .k_mm = {0, -1, 2}, .first_mm = {-4, 1, 3}};
  const Bytes message = message_of(sent);
  const auto image = igtl::parse_image(opened(message).content);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->body.size, (std::array<std::uint16_t, 3>{16, 12, 1}));
  EXPECT_EQ(image->pixels.size(), 16U * 12);
  EXPECT_EQ(image->pixels[5], 100);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_DOUBLE_EQ(image->body.pose.i_mm[axis], sent.pose.i_mm[axis]);
    EXPECT_DOUBLE_EQ(image->body.pose.j_mm[axis], sent.pose.j_mm[axis]);
    EXPECT_NEAR(image->body.pose.first_mm[axis], sent.pose.first_mm[axis], 1e-6);
  }
}

TEST(IgtlImage, HasItsCentreOnTheWay) {
  SentImage sent{.columns = 3, .rows = 5};
  sent.pose = {.i_mm = {2, 0, 0}, .j_mm = {0, 0, 4}, .k_mm = {0, 1, 0}, .first_mm = {10, 20, 30}};
  const Bytes message = message_of(sent);
  // The numbers of the matrix are big endian, whatever the pixels are. The last three are the place.
  const std::size_t matrix = igtl::kHeadBytes + 12;
  const auto number = [&](std::size_t at) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i) bits = bits << 8 | message[matrix + 4 * at + i];
    return std::bit_cast<float>(bits);
  };
  EXPECT_EQ(number(0), 2);
  EXPECT_EQ(number(5), 4);
  EXPECT_EQ(number(9), 10 + 2);
  EXPECT_EQ(number(10), 20);
  EXPECT_EQ(number(11), 30 + 8);
}

TEST(IgtlImage, OfLpsIsTurnedToRas) {
  SentImage sent;
  Bytes message = message_of(sent);
  Bytes content(message.begin() + igtl::kHeadBytes, message.end());
  content[5] = 2;
  const auto image = igtl::parse_image(content);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->body.pose.i_mm[0], -1);
  EXPECT_EQ(image->body.pose.j_mm[1], -1);
  EXPECT_EQ(image->body.pose.k_mm[2], 1);
}

TEST(IgtlImage, ThatContradictsItselfIsNone) {
  const Bytes message = message_of(SentImage{});
  const Bytes good(message.begin() + igtl::kHeadBytes, message.end());
  EXPECT_TRUE(igtl::parse_image(good));
  const auto refused = [&good](std::size_t at, std::uint8_t value) {
    Bytes changed = good;
    changed[at] = value;
    return !igtl::parse_image(changed);
  };
  EXPECT_TRUE(refused(1, 2)) << "version";
  EXPECT_TRUE(refused(2, 0)) << "components";
  EXPECT_TRUE(refused(2, 3)) << "components";
  EXPECT_TRUE(refused(3, 9)) << "type of number";
  EXPECT_TRUE(refused(4, 3)) << "byte order";
  EXPECT_TRUE(refused(5, 0)) << "axes";
  EXPECT_TRUE(refused(7, 0)) << "columns";
  EXPECT_TRUE(refused(12, 0x7F) && refused(13, 0xFF) == false) << "a number alone is not infinite";
  EXPECT_TRUE(refused(61, 1)) << "part beyond the image";
  EXPECT_TRUE(refused(67, 15)) << "part of another length";
  EXPECT_FALSE(igtl::parse_image(std::span(good).first(71)));
  EXPECT_FALSE(igtl::parse_image(std::span(good).first(good.size() - 1)));
  Bytes infinite = good;
  infinite[12] = 0x7F;
  infinite[13] = 0x80;
  infinite[14] = infinite[15] = 0;
  EXPECT_FALSE(igtl::parse_image(infinite));
}

TEST(IgtlTransform, HasItsColumnsInOrder) {
  const igtl::GridPose pose{.i_mm = {0, 1, 0}, .j_mm = {-1, 0, 0}, .k_mm = {0, 0, 1}, .first_mm = {5, 6, 7}};
  Bytes bytes;
  igtl::put_transform(bytes, pose);
  ASSERT_EQ(bytes.size(), igtl::kTransformBytes);
  EXPECT_EQ(bytes[4], 0x3F) << "R21 is the second number";
  const auto read = igtl::parse_transform(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->i_mm, pose.i_mm);
  EXPECT_EQ(read->first_mm, pose.first_mm);
  bytes.push_back(0);
  EXPECT_FALSE(igtl::parse_transform(bytes));
}

TEST(IgtlTransform, PlacesWhatIsWithinIt) {
  const igtl::GridPose outer{
      .i_mm = {0, 1, 0}, .j_mm = {-1, 0, 0}, .k_mm = {0, 0, 1}, .first_mm = {10, 0, 0}};
  const igtl::GridPose inner{.i_mm = {2, 0, 0}, .j_mm = {0, 2, 0}, .k_mm = {0, 0, 2}, .first_mm = {1, 0, 3}};
  const auto both = igtl::composed(outer, inner);
  EXPECT_EQ(both.i_mm, (std::array<double, 3>{0, 2, 0}));
  EXPECT_EQ(both.first_mm, (std::array<double, 3>{10, 1, 3}));
}

TEST(IgtlTexts, AreReadAsWritten) {
  Bytes status;
  igtl::put_status(status,
                   {.code = igtl::StatusCode::kNotReady, .sub_code = -5, .name = "waits", .text = "soon"});
  const auto read = igtl::parse_status(status);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->code, igtl::StatusCode::kNotReady);
  EXPECT_EQ(read->sub_code, -5);
  EXPECT_EQ(read->name.view(), "waits");
  EXPECT_EQ(read->text, "soon");
  EXPECT_FALSE(igtl::parse_status(std::span(status).first(29)));

  Bytes string;
  igtl::put_string(string, "liver");
  EXPECT_EQ(igtl::parse_string(string), "liver");
  EXPECT_FALSE(igtl::parse_string(std::span(string).first(8)));

  Bytes command;
  igtl::put_command(command, {.id = 4'000'000'000, .name = "SetParameter", .text = "<Command/>"});
  EXPECT_EQ(command.size(), 138U + 10);
  const auto ordered = igtl::parse_command(command);
  ASSERT_TRUE(ordered);
  EXPECT_EQ(ordered->id, 4'000'000'000U);
  EXPECT_EQ(ordered->name.view(), "SetParameter");
  EXPECT_EQ(ordered->text, "<Command/>");
  EXPECT_FALSE(igtl::parse_command(std::span(command).first(147)));

  Bytes capability;
  const std::vector<igtl::TypeName> types = {"IMAGE", "GET_CAPABIL"};
  igtl::put_capability(capability, types);
  EXPECT_EQ(igtl::parse_capability(capability), types);
  EXPECT_TRUE(igtl::parse_capability(std::span(capability).first(20)).empty());
}

}  // namespace message_tests
}  // namespace fanlight::test
