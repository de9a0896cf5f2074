// SPDX-License-Identifier: Apache-2.0
// OpenIGTLink's own library (Debian has 1.11) as the judge: it writes the same bytes as we do, and reads
// ours.
#include <gtest/gtest.h>
#include <igtlCapabilityMessage.h>
#include <igtlImageMessage.h>
#include <igtlStatusMessage.h>
#include <igtlStringMessage.h>
#include <igtlTrackingDataMessage.h>
#include <igtlTransformMessage.h>
#include <igtl_util.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "proto/base/clock.hpp"
#include "proto/base/crc64.hpp"
#include "proto/igtl/opened_message.hpp"
#include "proto/igtl/text_bodies.hpp"
#include "tests/igtl/sent_messages.hpp"

namespace fanlight::test {
namespace library_tests {

constexpr std::uint64_t kTime = (std::uint64_t{1'700'000'000} << 32) + 0x40000000;

template <typename Message>
Bytes packed(Message& message) {
  message->SetTimeStamp(1'700'000'000, 0x40000000);
  message->Pack();
  const auto* const first = static_cast<const std::uint8_t*>(message->GetPackPointer());
  return {first, first + message->GetPackSize()};
}

Bytes finished(igtl::MessageWriter& writer) {
  const auto message = writer.finish();
  return {message.begin(), message.end()};
}

/// Has the library read a message, its checksum too.
template <typename Message>
typename Message::Pointer read_by_library(const Bytes& bytes) {
  const auto head = ::igtl::MessageHeader::New();
  head->InitPack();
  std::memcpy(head->GetPackPointer(), bytes.data(), head->GetPackSize());
  head->Unpack();
  const auto message = Message::New();
  message->SetMessageHeader(head);
  message->AllocatePack();
  std::memcpy(message->GetPackBodyPointer(), bytes.data() + head->GetPackSize(), message->GetPackBodySize());
  EXPECT_NE(message->Unpack(1) & ::igtl::MessageHeader::UNPACK_BODY, 0);
  return message;
}

TEST(IgtlLibrary, WritesImagesAsWeDo) {
  SentImage sent;
  sent.pose = {.i_mm = {0.5, 0, 0}, .j_mm = {0, 0, 0.25}, .k_mm = {0, -1, 0}, .first_mm = {-3.75, 4, 2}};
  const auto theirs = ::igtl::ImageMessage::New();
  theirs->SetDeviceName("Image_Reference");
  theirs->SetDimensions(16, 12, 1);
  theirs->SetSpacing(0.5F, 0.25F, 1);
  theirs->SetScalarType(::igtl::ImageMessage::TYPE_UINT8);
  theirs->SetEndian(::igtl::ImageMessage::ENDIAN_LITTLE);  // they call single bytes big endian
  theirs->AllocateScalars();
  ::igtl::Matrix4x4 matrix;
  ::igtl::IdentityMatrix(matrix);
  matrix[1][1] = 0;
  matrix[2][1] = 1;
  matrix[1][2] = -1;
  matrix[2][2] = 0;
  // Their matrix has the centre.
  matrix[0][3] = -3.75F + 7.5F * 0.5F;
  matrix[1][3] = 4;
  matrix[2][3] = 2 + 5.5F * 0.25F;
  theirs->SetMatrix(matrix);
  std::memset(theirs->GetScalarPointer(), 100, 16 * 12);
  const Bytes bytes = packed(theirs);

  igtl::MessageWriter writer;
  const igtl::ImageBody body = body_of(sent);
  auto& ours = writer.begin({.type = "IMAGE", .device = "Image_Reference", .timestamp = kTime});
  igtl::put_image_header(ours, body);
  ours.insert(ours.end(), body.part_bytes(), 100);
  EXPECT_EQ(finished(writer), bytes);

  const auto parsed = igtl::parse_image(std::span(bytes).subspan(igtl::kHeadBytes));
  ASSERT_TRUE(parsed);
  EXPECT_NEAR(parsed->body.pose.first_mm[0], -3.75, 1e-6);
}

TEST(IgtlLibrary, ReadsOurColourImages) {
  SentImage sent;
  igtl::ImageBody body = body_of(sent);
  body.components = 3;
  const Bytes message = message_of(sent, body, Bytes(body.part_bytes(), 9));
  const auto read = read_by_library<::igtl::ImageMessage>(message);
  EXPECT_EQ(read->GetNumComponents(), 3);
  int size[3];
  read->GetDimensions(size);
  EXPECT_EQ(size[0], 16);
  EXPECT_EQ(static_cast<const unsigned char*>(read->GetScalarPointer())[100], 9);
}

TEST(IgtlLibrary, WritesTransformsAsWeDo) {
  const auto theirs = ::igtl::TransformMessage::New();
  theirs->SetDeviceName("ProbeToTracker");
  ::igtl::Matrix4x4 matrix;
  ::igtl::IdentityMatrix(matrix);
  matrix[0][1] = 0.5F;
  matrix[2][3] = -12.5F;
  theirs->SetMatrix(matrix);
  igtl::MessageWriter writer;
  igtl::put_transform(writer.begin({.type = "TRANSFORM", .device = "ProbeToTracker", .timestamp = kTime}),
                      {.j_mm = {0.5, 1, 0}, .first_mm = {0, 0, -12.5}});
  EXPECT_EQ(finished(writer), packed(theirs));
}

TEST(IgtlLibrary, WritesToolsThatWeRead) {
  const auto theirs = ::igtl::TrackingDataMessage::New();
  theirs->SetDeviceName("Tracker");
  for (const char* const name : {"Stylus", "Probe"}) {
    auto tool = ::igtl::TrackingDataElement::New();
    tool->SetName(name);
    tool->SetType(::igtl::TrackingDataElement::TYPE_6D);
    tool->SetPosition(1, 2, 3);
    theirs->AddTrackingDataElement(tool);
  }
  const Bytes bytes = packed(theirs);
  const auto content = std::span(bytes).subspan(igtl::kHeadBytes);
  ASSERT_EQ(igtl::tool_count(content), 2U);
  const auto tool = igtl::parse_tool(content, 1);
  ASSERT_TRUE(tool);
  EXPECT_EQ(tool->name.view(), "Probe");
  EXPECT_EQ(tool->pose.first_mm, (std::array<double, 3>{1, 2, 3}));
}

TEST(IgtlLibrary, AsksForToolsAsWeDo) {
  const auto theirs = ::igtl::StartTrackingDataMessage::New();
  theirs->SetDeviceName("Probe");
  theirs->SetResolution(50);
  theirs->SetCoordinateName("");
  igtl::MessageWriter writer;
  igtl::put_start_of_tools(writer.begin({.type = "STT_TDATA", .device = "Probe", .timestamp = kTime}), 50);
  EXPECT_EQ(finished(writer), packed(theirs));
}

TEST(IgtlLibrary, WritesTextsAsWeDo) {
  igtl::MessageWriter writer;
  const auto status = ::igtl::StatusMessage::New();
  status->SetDeviceName("Fanlight");
  status->SetCode(::igtl::StatusMessage::STATUS_NOT_READY);
  status->SetSubCode(7);
  status->SetErrorName("waits");
  status->SetStatusString("no frames");
  igtl::put_status(
      writer.begin({.type = "STATUS", .device = "Fanlight", .timestamp = kTime}),
      {.code = igtl::StatusCode::kNotReady, .sub_code = 7, .name = "waits", .text = "no frames"});
  EXPECT_EQ(finished(writer), packed(status));

  const auto string = ::igtl::StringMessage::New();
  string->SetDeviceName("Title");
  string->SetString("liver");
  igtl::put_string(writer.begin({.type = "STRING", .device = "Title", .timestamp = kTime}), "liver");
  EXPECT_EQ(finished(writer), packed(string));

  const auto capability = ::igtl::CapabilityMessage::New();
  capability->SetDeviceName("Fanlight");
  std::vector<std::string> names = {"IMAGE", "TRANSFORM"};
  capability->SetTypes(names);
  const std::vector<igtl::TypeName> types = {"IMAGE", "TRANSFORM"};
  igtl::put_capability(writer.begin({.type = "CAPABILITY", .device = "Fanlight", .timestamp = kTime}), types);
  EXPECT_EQ(finished(writer), packed(capability));
}

TEST(IgtlLibrary, HasTheSameChecksum) {
  Bytes bytes(1000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 37);
  EXPECT_EQ(crc64(bytes), ::crc64(bytes.data(), bytes.size(), 0));
}

/// Prints the rates of both.
TEST(IgtlLibrary, HasTheSameChecksumAndTakesLonger) {
  Bytes bytes(64'000'000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i >> 7);
  const auto mb_per_s = [&](std::int64_t began_ns) {
    return 1000 * static_cast<double>(bytes.size()) / static_cast<double>(now_ns() - began_ns);
  };
  const std::int64_t ours_ns = now_ns();
  const std::uint64_t ours = crc64(bytes);
  std::printf("isa-l:       %6.0f MB/s\n", mb_per_s(ours_ns));
  const std::int64_t theirs_ns = now_ns();
  const std::uint64_t theirs = ::crc64(bytes.data(), bytes.size(), 0);
  std::printf("the library: %6.0f MB/s\n", mb_per_s(theirs_ns));
  EXPECT_EQ(ours, theirs);
}

}  // namespace library_tests
}  // namespace fanlight::test
