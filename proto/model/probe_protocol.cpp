// SPDX-License-Identifier: Apache-2.0
#include "proto/model/probe_protocol.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <string_view>

#include "proto/base/crc32c.hpp"

namespace fanlight::probe {

namespace {

constexpr double kMicro = 1e6;
constexpr double kMicrometresInMm = 1e3;
constexpr double kNano = 1e9;
constexpr double kNanometresInMm = 1e6;
constexpr double kSixteenBits = 65536;
constexpr std::uint32_t kCountsVolumes = 1;
constexpr std::uint16_t kInvalidFrame = 1;

/// Writes a block from its front.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> to) : to_(to) {}

  template <std::unsigned_integral T>
  Writer& put(T value) {
    for (std::size_t byte = 0; byte < sizeof(T); ++byte) {
      to_[at_++] = static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * byte));
    }
    return *this;
  }
  /// A quantity in units of 1 / scale, signed or unsigned as T; clamped to the range of T.
  template <typename T>
  Writer& put_scaled(double value, double scale) {
    const double whole =
        std::clamp(std::round(value * scale), static_cast<double>(std::numeric_limits<T>::min()),
                   static_cast<double>(std::numeric_limits<T>::max()));
    return put(static_cast<std::make_unsigned_t<T>>(static_cast<T>(whole)));
  }
  Writer& put_text(std::string_view text, std::size_t bytes) {
    for (std::size_t byte = 0; byte < bytes; ++byte)
      put(static_cast<std::uint8_t>(byte < text.size() ? text[byte] : 0));
    return *this;
  }
  Writer& put_bytes(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) put(byte);
    return *this;
  }
  std::span<const std::uint8_t> written() const { return to_.first(at_); }

 private:
  std::span<std::uint8_t> to_;
  std::size_t at_ = 0;
};

/// Reads a block from its front. The caller has checked its length.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> from) : from_(from) {}

  template <std::unsigned_integral T>
  T get() {
    std::uint64_t value = 0;
    for (std::size_t byte = 0; byte < sizeof(T); ++byte) value |= std::uint64_t{from_[at_++]} << (8 * byte);
    return static_cast<T>(value);
  }
  template <typename T>
  double get_scaled(double scale) {
    return static_cast<double>(static_cast<T>(get<std::make_unsigned_t<T>>())) / scale;
  }
  std::string get_text(std::size_t bytes) {
    std::string text;
    for (std::size_t byte = 0; byte < bytes; ++byte) {
      const auto next = static_cast<char>(get<std::uint8_t>());
      if (next == 0) {
        at_ += bytes - byte - 1;
        break;
      }
      text.push_back(next >= ' ' && next <= '~' ? next : '?');
    }
    return text;
  }
  void skip(std::size_t bytes) { at_ += bytes; }

 private:
  std::span<const std::uint8_t> from_;
  std::size_t at_ = 0;
};

template <std::size_t kBytes>
Writer begin(std::array<std::uint8_t, kBytes>& block) {
  Writer to(block);
  to.put(static_cast<std::uint16_t>(kBytes)).put(kVersion);
  return to;
}

/// Checks the length and the version at the front of every block.
Result<Reader> open_block(std::span<const std::uint8_t> block, std::string_view name, std::size_t expected) {
  if (block.size() < expected) {
    return Error{ErrorCode::kBadInput, fmt::format("the probe's {} has {} bytes, expected {} or more", name,
                                                   block.size(), expected)};
  }
  Reader from(block);
  const auto length = from.get<std::uint16_t>();
  const auto version = from.get<std::uint16_t>();
  if (version >> 8 != kVersion >> 8) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("the probe speaks version {}.{} of the protocol, expected {}.x", version >> 8,
                             version & 0xFF, kVersion >> 8)};
  }
  if (length < expected) {
    return Error{ErrorCode::kBadInput, fmt::format("the probe's {} says it has {} bytes, expected {} or more",
                                                   name, length, expected)};
  }
  return from;
}

Result<void> check_range(std::string_view name, double least, double most, double lowest, double highest) {
  if (least <= most && least >= lowest && most <= highest) return {};
  return Error{ErrorCode::kBadInput,
               fmt::format("the probe offers a {} of {} to {}, expected a range within {} to {}", name, least,
                           most, lowest, highest)};
}

}  // namespace

std::array<std::uint8_t, kIdentityBytes> encode(const Identity& identity) {
  std::array<std::uint8_t, kIdentityBytes> block{};
  begin(block).put_text(identity.model, 32).put_text(identity.serial, 32).put_text(identity.firmware, 24);
  return block;
}

Result<Identity> decode_identity(std::span<const std::uint8_t> block) {
  auto from = open_block(block, "identity", kIdentityBytes);
  if (!from) return from.error();
  Identity identity;
  identity.model = from->get_text(32);
  identity.serial = from->get_text(32);
  identity.firmware = from->get_text(24);
  return identity;
}

std::array<std::uint8_t, kCapabilitiesBytes> encode(const Capabilities& capabilities) {
  std::array<std::uint8_t, kCapabilitiesBytes> block{};
  begin(block)
      .put(capabilities.counts_volumes ? kCountsVolumes : 0)
      .put(capabilities.pixel_formats)
      .put_scaled<std::uint32_t>(capabilities.least_sweep_deg, kMicro)
      .put_scaled<std::uint32_t>(capabilities.most_sweep_deg, kMicro)
      .put(capabilities.least_frames)
      .put(capabilities.most_frames)
      .put_scaled<std::uint32_t>(capabilities.least_depth_mm, kMicrometresInMm)
      .put_scaled<std::uint32_t>(capabilities.most_depth_mm, kMicrometresInMm)
      .put(capabilities.most_columns)
      .put(capabilities.most_rows);
  return block;
}

Result<Capabilities> decode_capabilities(std::span<const std::uint8_t> block) {
  auto from = open_block(block, "capabilities", kCapabilitiesBytes);
  if (!from) return from.error();
  Capabilities offered;
  offered.counts_volumes = (from->get<std::uint32_t>() & kCountsVolumes) != 0;
  offered.pixel_formats = from->get<std::uint32_t>();
  offered.least_sweep_deg = from->get_scaled<std::uint32_t>(kMicro);
  offered.most_sweep_deg = from->get_scaled<std::uint32_t>(kMicro);
  offered.least_frames = from->get<std::uint32_t>();
  offered.most_frames = from->get<std::uint32_t>();
  offered.least_depth_mm = from->get_scaled<std::uint32_t>(kMicrometresInMm);
  offered.most_depth_mm = from->get_scaled<std::uint32_t>(kMicrometresInMm);
  offered.most_columns = from->get<std::uint32_t>();
  offered.most_rows = from->get<std::uint32_t>();
  if ((offered.pixel_formats & 1) == 0) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("the probe offers the pixel formats {:#x}, expected 8 bit grey (0x1) among them",
                             offered.pixel_formats)};
  }
  if (auto ok = check_range("sweep", offered.least_sweep_deg, offered.most_sweep_deg, 0.1, 178); !ok)
    return ok.error();
  if (auto ok = check_range("number of frames", offered.least_frames, offered.most_frames, 2, 1024); !ok) {
    return ok.error();
  }
  if (auto ok = check_range("depth", offered.least_depth_mm, offered.most_depth_mm, 1, 1000); !ok)
    return ok.error();
  if (auto ok = check_range("number of columns", 2, offered.most_columns, 2, 4096); !ok) return ok.error();
  if (auto ok = check_range("number of rows", 2, offered.most_rows, 2, 4096); !ok) return ok.error();
  return offered;
}

std::array<std::uint8_t, kGeometryBytes> encode(const Geometry& geometry) {
  const FanGeometry& fan = geometry.fan;
  std::array<std::uint8_t, kGeometryBytes> block{};
  begin(block)
      .put(geometry.revision)
      .put(static_cast<std::uint32_t>(fan.kind))
      .put(static_cast<std::uint16_t>(fan.columns))
      .put(static_cast<std::uint16_t>(fan.rows))
      .put_scaled<std::uint32_t>(fan.pixel_width_mm, kNanometresInMm)
      .put_scaled<std::uint32_t>(fan.pixel_height_mm, kNanometresInMm)
      .put_scaled<std::int32_t>(fan.face_column, kSixteenBits)
      .put_scaled<std::int32_t>(fan.face_row, kSixteenBits)
      .put_scaled<std::uint32_t>(fan.motor_radius_mm, kMicrometresInMm)
      .put_scaled<std::uint32_t>(fan.probe_radius_mm, kMicrometresInMm)
      .put_scaled<std::uint32_t>(fan.line_pitch_deg, kNano)
      .put_scaled<std::uint32_t>(fan.sector.half_angle_deg, kMicro)
      .put_scaled<std::uint32_t>(fan.sector.reach_mm, kMicrometresInMm);
  return block;
}

Result<Geometry> decode_geometry(std::span<const std::uint8_t> block) {
  auto from = open_block(block, "geometry", kGeometryBytes);
  if (!from) return from.error();
  Geometry geometry;
  FanGeometry& fan = geometry.fan;
  geometry.revision = from->get<std::uint32_t>();
  const auto kind = from->get<std::uint32_t>();
  if (kind > static_cast<std::uint32_t>(FrameKind::kLinearLines)) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("the probe's frames are of kind {}, expected 0 to 2", kind)};
  }
  fan.kind = static_cast<FrameKind>(kind);
  fan.columns = from->get<std::uint16_t>();
  fan.rows = from->get<std::uint16_t>();
  fan.pixel_width_mm = from->get_scaled<std::uint32_t>(kNanometresInMm);
  fan.pixel_height_mm = from->get_scaled<std::uint32_t>(kNanometresInMm);
  fan.face_column = from->get_scaled<std::int32_t>(kSixteenBits);
  fan.face_row = from->get_scaled<std::int32_t>(kSixteenBits);
  fan.motor_radius_mm = from->get_scaled<std::uint32_t>(kMicrometresInMm);
  fan.probe_radius_mm = from->get_scaled<std::uint32_t>(kMicrometresInMm);
  fan.line_pitch_deg = from->get_scaled<std::uint32_t>(kNano);
  fan.sector.half_angle_deg = from->get_scaled<std::uint32_t>(kMicro);
  fan.sector.reach_mm = from->get_scaled<std::uint32_t>(kMicrometresInMm);
  if (auto checked = check(fan); !checked) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("the probe's geometry cannot be: {}", checked.error().message)};
  }
  return geometry;
}

std::array<std::uint8_t, kSettingsBytes> encode(const Settings& settings) {
  std::array<std::uint8_t, kSettingsBytes> block{};
  begin(block)
      .put_scaled<std::uint32_t>(settings.sweep_deg, kMicro)
      .put(settings.frames_a_volume)
      .put_scaled<std::uint32_t>(settings.depth_mm, kMicrometresInMm);
  return block;
}

Result<Settings> decode_settings(std::span<const std::uint8_t> block) {
  auto from = open_block(block, "settings", kSettingsBytes);
  if (!from) return from.error();
  Settings settings;
  settings.sweep_deg = from->get_scaled<std::uint32_t>(kMicro);
  settings.frames_a_volume = from->get<std::uint32_t>();
  settings.depth_mm = from->get_scaled<std::uint32_t>(kMicrometresInMm);
  return settings;
}

std::array<std::uint8_t, kFrameHeaderBytes> encode(const FrameHeader& header) {
  std::array<std::uint8_t, kFrameHeaderBytes> block{};
  Writer to(block);
  to.put_bytes(kMagic)
      .put(kVersion)
      .put(static_cast<std::uint16_t>(kFrameHeaderBytes))
      .put(header.sequence)
      .put(header.device_time_ns)
      .put(header.volume_index)
      .put(header.frame_index)
      .put(header.frames_in_sweep)
      .put_scaled<std::int32_t>(header.angle_deg, kMicro)
      .put(static_cast<std::uint8_t>(header.direction))
      .put(static_cast<std::uint8_t>(header.format))
      .put(header.invalid ? kInvalidFrame : std::uint16_t{0})
      .put(header.geometry_revision)
      .put(header.payload_bytes)
      .put(header.payload_crc32c)
      .put(std::uint64_t{0});  // reserved
  to.put(crc32c(to.written()));
  return block;
}

HeaderCheck read_header(std::span<const std::uint8_t> bytes, FrameHeader& header, std::size_t& header_bytes) {
  const std::size_t magic_here = std::min(bytes.size(), kMagic.size());
  if (!std::equal(bytes.begin(), bytes.begin() + magic_here, kMagic.begin())) return HeaderCheck::kNoHeader;
  if (bytes.size() < 8) return HeaderCheck::kMore;
  Reader from(bytes);
  from.skip(kMagic.size());
  const auto version = from.get<std::uint16_t>();
  const std::size_t length = from.get<std::uint16_t>();
  if (version >> 8 != kVersion >> 8 || length < kFrameHeaderBytes || length > kMostFrameHeaderBytes) {
    return HeaderCheck::kNoHeader;
  }
  if (bytes.size() < length) return HeaderCheck::kMore;
  // The checksum comes last, so that it covers fields added by later minor versions.
  constexpr std::size_t kChecksumBytes = 4;
  Reader checksum(bytes.subspan(length - kChecksumBytes));
  if (checksum.get<std::uint32_t>() != crc32c(bytes.first(length - kChecksumBytes)))
    return HeaderCheck::kNoHeader;

  header.sequence = from.get<std::uint64_t>();
  header.device_time_ns = from.get<std::uint64_t>();
  header.volume_index = from.get<std::uint32_t>();
  header.frame_index = from.get<std::uint16_t>();
  header.frames_in_sweep = from.get<std::uint16_t>();
  header.angle_deg = from.get_scaled<std::int32_t>(kMicro);
  header.direction = from.get<std::uint8_t>() == 0 ? SweepDirection::kForward : SweepDirection::kBackward;
  header.format = static_cast<PixelFormat>(from.get<std::uint8_t>());
  header.invalid = (from.get<std::uint16_t>() & kInvalidFrame) != 0;
  header.geometry_revision = from.get<std::uint32_t>();
  header.payload_bytes = from.get<std::uint32_t>();
  header.payload_crc32c = from.get<std::uint32_t>();
  if (header.payload_bytes > kMostPayloadBytes) return HeaderCheck::kNoHeader;
  header_bytes = length;
  return HeaderCheck::kHeader;
}

}  // namespace fanlight::probe
