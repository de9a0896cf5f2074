// SPDX-License-Identifier: Apache-2.0
// The corpus of messages, which a program wrote that shares no code with ours: we read it, and write the
// same.
#include "tests/igtl/corpus.hpp"

#include <array>
#include <cmath>
#include <cstring>

#include "proto/igtl/image_body.hpp"
#include "proto/igtl/message_writer.hpp"
#include "proto/igtl/pose_bodies.hpp"
#include "proto/igtl/text_bodies.hpp"
#include "proto/igtl/timestamp.hpp"
#include "proto/igtl/video_body.hpp"

namespace fanlight::test {
namespace corpus_tests {

using igtl::HeadVersion;
using Bytes = std::vector<std::uint8_t>;
using State = igtl::OpenedMessage::State;

constexpr igtl::GridPose kPose{
    .i_mm = {0.5, 0, 0}, .j_mm = {0, 0, 0.25}, .k_mm = {0, -1, 0}, .first_mm = {10, 20, 30}};
constexpr igtl::GridPose kTurn{
    .i_mm = {1, 0, 0}, .j_mm = {0, 0, 1}, .k_mm = {0, -1, 0}, .first_mm = {1.5, -2.5, 3.5}};
constexpr std::array<std::pair<std::string_view, std::string_view>, 2> kItems = {
    {{"MotorAngleDeg", "-12.5"}, {"VolumeIndex", "3"}}};
constexpr std::string_view kXml =
    "<Command Name=\"GetParameter\"><Parameter Name=\"light.up_mm\"/></Command>";

struct Read {
  Bytes message;
  igtl::MessageHead head;

  explicit Read(const std::string& name)
      : message(corpus_message(name)),
        head(*igtl::parse_head(std::span(message).first<igtl::kHeadBytes>())) {}
  igtl::OpenedMessage opened() const {
    return igtl::open_message(head, std::span(message).subspan(igtl::kHeadBytes));
  }
};

Bytes twelve_pixels() {
  Bytes pixels(12);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i);
  return pixels;
}

igtl::ImageBody small_image() {
  igtl::ImageBody image{.pose = kPose};
  image.size = image.part_size = {4, 3, 1};
  return image;
}

template <typename Put>
Bytes written(std::string_view type, std::string_view device, Put put,
              HeadVersion version = HeadVersion::kOne, std::uint32_t id = 0, igtl::MetadataItems items = {}) {
  igtl::MessageWriter writer;
  put(writer.begin({.type = igtl::TypeName(type),
                    .device = igtl::DeviceName(device),
                    .timestamp = igtl::timestamp_of(kCorpusNs),
                    .version = version,
                    .message_id = id,
                    .metadata = items}));
  const auto message = writer.finish();
  return {message.begin(), message.end()};
}

auto image_with(const igtl::ImageBody& image, const Bytes& pixels) {
  return [&image, &pixels](Bytes& bytes) {
    igtl::put_image_header(bytes, image);
    bytes.insert(bytes.end(), pixels.begin(), pixels.end());
  };
}

void expect_near(const igtl::GridPose& pose, const igtl::GridPose& expected) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(pose.i_mm[axis], expected.i_mm[axis], 1e-5);
    EXPECT_NEAR(pose.j_mm[axis], expected.j_mm[axis], 1e-5);
    EXPECT_NEAR(pose.k_mm[axis], expected.k_mm[axis], 1e-5);
    EXPECT_NEAR(pose.first_mm[axis], expected.first_mm[axis], 1e-5);
  }
}

TEST(IgtlCorpus, ImagesAreWhereTheyAre) {
  const Bytes pixels = twelve_pixels();
  for (const char* const name : {"image_8_bit", "image_lps", "image_version_2", "image_version_3"}) {
    SCOPED_TRACE(name);
    const Read read(name);
    ASSERT_EQ(read.opened().state, State::kGood);
    EXPECT_EQ(read.head.type.view(), "IMAGE");
    EXPECT_EQ(read.head.device.view(), "Image_Reference");
    EXPECT_EQ(igtl::ns_of(read.head.timestamp), kCorpusNs);
    const auto image = igtl::parse_image(read.opened().content);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->body.size, (std::array<std::uint16_t, 3>{4, 3, 1}));
    EXPECT_EQ(Bytes(image->pixels.begin(), image->pixels.end()), pixels);
    expect_near(image->body.pose, kPose);
  }
  const Read read("image_version_2");
  EXPECT_EQ(read.opened().message_id, 77U);
  EXPECT_EQ(read.opened().metadata.find("MotorAngleDeg"), "-12.5");
  EXPECT_EQ(read.opened().metadata.find("VolumeIndex"), "3");
}

TEST(IgtlCorpus, ImagesOfOtherFormsAreRead) {
  const Read wide("image_16_bit_big_endian");
  const auto image = igtl::parse_image(wide.opened().content);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->body.scalar, igtl::ScalarType::kUint16);
  EXPECT_TRUE(image->body.big_endian);
  EXPECT_EQ(image->pixels[22], 11);
  const Read part("image_part");
  const auto slab = igtl::parse_image(part.opened().content);
  ASSERT_TRUE(slab);
  EXPECT_FALSE(slab->body.is_whole());
  EXPECT_EQ(slab->body.part_offset[1], 1);
  EXPECT_EQ(slab->body.part_size[1], 2);
  expect_near(slab->body.pose, kPose);
}

TEST(IgtlCorpus, ImagesAreWrittenTheSame) {
  const igtl::ImageBody image = small_image();
  const Bytes pixels = twelve_pixels();
  EXPECT_EQ(written("IMAGE", "Image_Reference", image_with(image, pixels)), corpus_message("image_8_bit"));
  EXPECT_EQ(written("IMAGE", "Image_Reference", image_with(image, pixels), HeadVersion::kTwo, 77, kItems),
            corpus_message("image_version_2"));
  igtl::ImageBody volume = image;
  volume.size = volume.part_size = {2, 3, 2};
  // The corpus has the same numbers of the matrix: the first voxel lies elsewhere then.
  volume.pose.first_mm = {10.5, 20.5, 30};
  EXPECT_EQ(written("IMAGE", "Volume_Transducer", image_with(volume, pixels)),
            corpus_message("image_volume"));
}

TEST(IgtlCorpus, PosesAreTheSame) {
  const Read transform("transform");
  const auto pose = igtl::parse_transform(transform.opened().content);
  ASSERT_TRUE(pose);
  expect_near(*pose, kTurn);
  EXPECT_EQ(written("TRANSFORM", "ProbeToReference", [](Bytes& bytes) { igtl::put_transform(bytes, kTurn); }),
            transform.message);
  const Read tdata("tdata");
  ASSERT_EQ(tdata.opened().content.size(), 2 * igtl::kToolBytes);
  const auto tool = igtl::parse_tool(tdata.opened().content, 1);
  ASSERT_TRUE(tool);
  EXPECT_EQ(tool->name.view(), "StylusToReference");
  expect_near(tool->pose, kTurn);
  EXPECT_EQ(written("STT_TDATA", "", [](Bytes& bytes) { igtl::put_start_of_tools(bytes, 20); }),
            corpus_message("start_of_tdata"));
}

TEST(IgtlCorpus, TextsAreTheSame) {
  EXPECT_EQ(written("STT_IMAGE", "Picture_Transducer", [](Bytes& /*bytes*/) {}),
            corpus_message("start_of_image"));
  EXPECT_EQ(written(
                "STT_IMAGE", "Picture_Transducer", [](Bytes& /*bytes*/) {}, HeadVersion::kTwo),
            corpus_message("start_of_image_version_2"));
  EXPECT_EQ(written("GET_IMAGE", "Depth_Transducer", [](Bytes& /*bytes*/) {}), corpus_message("query"));
  const Read status("status");
  const auto state = igtl::parse_status(status.opened().content);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->code, igtl::StatusCode::kNotReady);
  EXPECT_EQ(state->sub_code, -5);
  EXPECT_EQ(state->name.view(), "waiting");
  EXPECT_EQ(state->text, "no picture yet");
  EXPECT_EQ(written("STATUS", "Fanlight", [&](Bytes& bytes) { igtl::put_status(bytes, *state); }),
            status.message);
  EXPECT_EQ(written("STRING", "CMD_7", [](Bytes& bytes) { igtl::put_string(bytes, kXml); }),
            corpus_message("string"));
  const igtl::TypeName types[] = {"IMAGE", "GET_CAPABIL"};
  EXPECT_EQ(written("CAPABILITY", "Fanlight", [&](Bytes& bytes) { igtl::put_capability(bytes, types); }),
            corpus_message("capability"));
  const Read command("command");
  const auto order = igtl::parse_command(command.opened().content);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->id, 9U);
  EXPECT_EQ(order->name.view(), "GetParameter");
  EXPECT_EQ(order->text, kXml);
  EXPECT_EQ(written(
                "RTS_COMMAND", "Fanlight",
                [](Bytes& bytes) {
                  igtl::put_command(bytes, {.id = 9, .name = "GetParameter", .text = "<CommandReply/>"});
                },
                HeadVersion::kTwo),
            corpus_message("reply_to_command"));
}

TEST(IgtlCorpus, VideoIsWrittenTheSame) {
  const auto video = [](igtl::VideoFrame frame, std::string_view coded) {
    return [frame, coded](Bytes& bytes) {
      igtl::put_video_header(bytes, {4, 2, 1}, kPose, frame);
      bytes.insert(bytes.end(), coded.begin(), coded.end());
    };
  };
  using namespace std::string_view_literals;
  EXPECT_EQ(written("VIDEO", "Video_Transducer", video(igtl::VideoFrame::kKey, "\0\0\0\1\x67key"sv)),
            corpus_message("video_key"));
  EXPECT_EQ(written("VIDEO", "Video_Transducer", video(igtl::VideoFrame::kPredicted, "\0\0\0\1\x41next"sv),
                    HeadVersion::kTwo, 78, kItems),
            corpus_message("video_predicted"));
}

TEST(IgtlCorpus, DamagedMessagesAreRefused) {
  EXPECT_EQ(Read("bad_checksum").opened().state, State::kDamaged);
  EXPECT_EQ(Read("bad_extended_header").opened().state, State::kMalformed);
  EXPECT_EQ(Read("bad_metadata").opened().state, State::kMalformed);
  EXPECT_GT(Read("bad_length").head.body_bytes, std::uint64_t{1} << 62);
  const Read image("bad_image_size");
  EXPECT_EQ(image.opened().state, State::kGood);
  EXPECT_FALSE(igtl::parse_image(image.opened().content));
  const Read command("bad_command_length");
  EXPECT_EQ(command.opened().state, State::kGood);
  EXPECT_FALSE(igtl::parse_command(command.opened().content));
}

}  // namespace corpus_tests
}  // namespace fanlight::test
