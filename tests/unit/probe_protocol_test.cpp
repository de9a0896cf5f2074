// SPDX-License-Identifier: Apache-2.0
#include "proto/model/probe_protocol.hpp"

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

#include "proto/base/crc32c.hpp"

namespace fanlight::probe {
namespace {

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// RFC 3720, B.4, and the usual check value.
TEST(Crc32c, KnownValues) {
  EXPECT_EQ(crc32c({}), 0U);
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xE3069283U);
  EXPECT_EQ(crc32c(std::vector<std::uint8_t>(32, 0)), 0x8A9136AAU);
  EXPECT_EQ(crc32c(std::vector<std::uint8_t>(32, 0xFF)), 0x62A8AB43U);
}

TEST(Crc32c, TheSameInPieces) {
  Crc32c crc;
  for (const std::string_view piece : {"1", "", "2345678", "9"}) crc.add(bytes_of(piece));
  EXPECT_EQ(crc.value(), 0xE3069283U);
}

FrameHeader a_header() {
  return {.sequence = 0x0102030405060708,
          .device_time_ns = 0x1112131415161718,
          .volume_index = 0x21222324,
          .frame_index = 34,
          .frames_in_sweep = 35,
          .angle_deg = -34.125,
          .direction = SweepDirection::kBackward,
          .invalid = true,
          .geometry_revision = 7,
          .payload_bytes = 512 * 512,
          .payload_crc32c = 0xE3069283};
}

Geometry a_geometry() {
  Geometry geometry{.revision = 3};
  geometry.fan = {.columns = 512,
                  .rows = 400,
                  .pixel_width_mm = 0.3125,
                  .pixel_height_mm = 0.25,
                  .face_column = 255.5,
                  .face_row = -12.25,
                  .motor_radius_mm = 30,
                  .probe_radius_mm = 50};
  geometry.fan.sector = {.half_angle_deg = 35, .reach_mm = 210};
  return geometry;
}

TEST(ProbeProtocol, AHeaderLiesOnTheWireAsItsTextSays) {
  const auto wire = encode(a_header());
  const std::vector<std::uint8_t> expected = {
      0x46, 0x4C, 0x50, 0x46, 0x00, 0x01, 0x40, 0x00,  // magic, version, length
      0x08, 0x07, 0x06, 0x05, 0x04, 0x03, 0x02, 0x01,  // sequence
      0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11,  // device time
      0x24, 0x23, 0x22, 0x21, 0x22, 0x00, 0x23, 0x00,  // volume, frame, frames
      0x38, 0x4B, 0xF7, 0xFD, 0x01, 0x01, 0x01, 0x00,  // -34 125 000 microdegrees, backward, grey, invalid
      0x07, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04, 0x00,  // geometry, payload
      0x83, 0x92, 0x06, 0xE3, 0x00, 0x00, 0x00, 0x00,  // checksum, reserved
      0x00, 0x00, 0x00, 0x00};
  EXPECT_EQ(std::vector(wire.begin(), wire.begin() + expected.size()), expected);
  ASSERT_EQ(expected.size() + 4, wire.size());
  FrameHeader read;
  std::size_t length = 0;
  ASSERT_EQ(read_header(wire, read, length), HeaderCheck::kHeader);
  EXPECT_EQ(length, kFrameHeaderBytes);
  EXPECT_EQ(read, a_header());
}

// The example at the end of usb_probe.md.
TEST(ProbeProtocol, TheExampleOfTheTextIsWhatWeSend) {
  const std::array<std::uint8_t, kFrameHeaderBytes> example = {
      0x46, 0x4C, 0x50, 0x46, 0x00, 0x01, 0x40, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x00, 0xCA, 0x9A, 0x3B, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00, 0x23, 0x00,
      0xA0, 0xD4, 0x00, 0xFE, 0x00, 0x01, 0x00, 0x00, 0x07, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00,
      0xC7, 0x4B, 0x67, 0x48, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x8F, 0x8F, 0x7E, 0x29};
  EXPECT_EQ(encode(FrameHeader{.sequence = 1,
                               .device_time_ns = 1'000'000'000,
                               .frame_index = 1,
                               .frames_in_sweep = 35,
                               .angle_deg = -33.5,
                               .geometry_revision = 7,
                               .payload_bytes = 4,
                               .payload_crc32c = crc32c(std::vector<std::uint8_t>(4, 0))}),
            example);
}

TEST(ProbeProtocol, EveryFlippedBitOfAHeaderIsSeen) {
  const auto wire = encode(a_header());
  for (std::size_t bit = 0; bit < 8 * wire.size(); ++bit) {
    auto flipped = wire;
    flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    FrameHeader read;
    std::size_t length = 0;
    EXPECT_NE(read_header(flipped, read, length), HeaderCheck::kHeader) << "bit " << bit;
  }
}

TEST(ProbeProtocol, ABeginningOfAHeaderWantsMore) {
  const auto wire = encode(a_header());
  FrameHeader read;
  std::size_t length = 0;
  for (std::size_t bytes = 0; bytes < wire.size(); ++bytes) {
    EXPECT_EQ(read_header(std::span(wire).first(bytes), read, length), HeaderCheck::kMore) << bytes;
  }
}

TEST(ProbeProtocol, ALaterMinorVersionsLongerHeaderIsRead) {
  const auto wire = encode(a_header());
  std::vector<std::uint8_t> longer(96, 0x55);
  std::copy(wire.begin(), wire.end() - 4, longer.begin());
  longer[4] = 3;  // version 1.3
  longer[6] = 100;
  const std::uint32_t crc = crc32c(longer);
  for (int byte = 0; byte < 4; ++byte) longer.push_back(static_cast<std::uint8_t>(crc >> (8 * byte)));
  FrameHeader read;
  std::size_t length = 0;
  ASSERT_EQ(read_header(longer, read, length), HeaderCheck::kHeader);
  EXPECT_EQ(length, 100U);
  EXPECT_EQ(read, a_header());
}

TEST(ProbeProtocol, APayloadBeyondTheLimitIsNoHeader) {
  FrameHeader header = a_header();
  header.payload_bytes = kMostPayloadBytes + 1;
  std::size_t length = 0;
  EXPECT_EQ(read_header(encode(header), header, length), HeaderCheck::kNoHeader);
}

TEST(ProbeProtocol, BlocksComeBackAsTheyWent) {
  const Identity identity{.model = "FL-1", .serial = "0007", .firmware = "1.2.3"};
  EXPECT_EQ(decode_identity(encode(identity)).value(), identity);
  const Capabilities capabilities{.counts_volumes = false,
                                  .least_sweep_deg = 10,
                                  .most_sweep_deg = 85.5,
                                  .least_frames = 8,
                                  .most_frames = 140,
                                  .least_depth_mm = 40,
                                  .most_depth_mm = 240,
                                  .most_columns = 512,
                                  .most_rows = 768};
  EXPECT_EQ(decode_capabilities(encode(capabilities)).value(), capabilities);
  EXPECT_EQ(decode_geometry(encode(a_geometry())).value(), a_geometry());
  const Settings settings{.sweep_deg = 70, .frames_a_volume = 35, .depth_mm = 160};
  EXPECT_EQ(decode_settings(encode(settings)).value(), settings);
}

TEST(ProbeProtocol, BlocksThatCannotBeAreRefusedWithASentence) {
  const auto good = encode(a_geometry());
  EXPECT_EQ(decode_geometry(std::span(good).first(40)).error().message,
            "the probe's geometry has 40 bytes, expected 52 or more");
  auto other_major = good;
  other_major[3] = 2;
  EXPECT_EQ(decode_geometry(other_major).error().message,
            "the probe speaks version 2.0 of the protocol, expected 1.x");
  auto shorter = good;
  shorter[0] = 20;
  EXPECT_EQ(decode_geometry(shorter).error().code, ErrorCode::kBadInput);
  auto kind = good;
  kind[8] = 9;
  EXPECT_EQ(decode_geometry(kind).error().code, ErrorCode::kUnsupported);
  auto flat = a_geometry();
  flat.fan.motor_radius_mm = 0;
  EXPECT_EQ(decode_geometry(encode(flat)).error().code, ErrorCode::kBadInput);
  EXPECT_EQ(decode_capabilities(encode(Capabilities{})).error().code, ErrorCode::kBadInput);
}

}  // namespace
}  // namespace fanlight::probe
