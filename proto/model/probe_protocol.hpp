// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "proto/base/result.hpp"
#include "proto/model/fan_geometry.hpp"
#include "proto/model/frame.hpp"

/// USB probe protocol, version 1, for both ends of the cable; described in usb_probe.md. All numbers are
/// little endian. Allocates only the texts of Identity.
namespace fanlight::probe {

inline constexpr std::uint16_t kVersion = 0x0100;  ///< major in the upper byte, minor in the lower

// Interface class of a probe, and its requests (bRequest).
inline constexpr std::uint8_t kInterfaceClass = 0xFF;
inline constexpr std::uint8_t kInterfaceSubclass = 0x46;
inline constexpr std::uint8_t kInterfaceProtocol = 0x01;

enum class Request : std::uint8_t {
  kIdentity = 0x01,      ///< in
  kCapabilities = 0x02,  ///< in
  kGeometry = 0x03,      ///< in
  kSettings = 0x04,      ///< in
  kSetSweep = 0x10,      ///< out: u32, microdegrees from the first frame to the last
  kSetFrames = 0x11,     ///< out: u32, frames a volume
  kSetDepth = 0x12,      ///< out: u32, micrometres
  kStart = 0x20,         ///< out, no data
  kStop = 0x21,          ///< out, no data
};

struct Identity {
  std::string model;     ///< up to 32 bytes of printable ASCII; other bytes are read as '?'
  std::string serial;    ///< up to 32 bytes, equal to the device's USB serial number
  std::string firmware;  ///< up to 24 bytes

  bool operator==(const Identity&) const = default;
};
inline constexpr std::size_t kIdentityBytes = 92;

/// Capabilities of a probe, and the ranges of its settings.
struct Capabilities {
  /// Frames carry a valid volume index; otherwise the ends of sweeps are found from the reversals of the
  /// angle.
  bool counts_volumes = true;
  std::uint32_t pixel_formats = 1;  ///< bit n: PixelFormat n + 1
  double least_sweep_deg = 0;
  double most_sweep_deg = 0;
  std::uint32_t least_frames = 0;  ///< frames in a volume
  std::uint32_t most_frames = 0;
  double least_depth_mm = 0;
  double most_depth_mm = 0;
  std::uint32_t most_columns = 0;
  std::uint32_t most_rows = 0;

  bool operator==(const Capabilities&) const = default;
};
inline constexpr std::size_t kCapabilitiesBytes = 44;

/// Geometry of frames, with the revision by which frames refer to it.
struct Geometry {
  std::uint32_t revision = 0;
  FanGeometry fan;

  bool operator==(const Geometry&) const = default;
};
inline constexpr std::size_t kGeometryBytes = 52;

struct Settings {
  double sweep_deg = 0;  ///< whole range, half to either side of the middle
  std::uint32_t frames_a_volume = 0;
  double depth_mm = 0;

  bool operator==(const Settings&) const = default;
};
inline constexpr std::size_t kSettingsBytes = 16;

enum class PixelFormat : std::uint8_t { kGrey8 = 1 };

/// Header before the pixels of each frame on the bulk pipe.
struct FrameHeader {
  std::uint64_t sequence = 0;
  std::uint64_t device_time_ns = 0;  ///< capture time on the probe's own clock
  std::uint32_t volume_index = 0;
  std::uint16_t frame_index = 0;
  std::uint16_t frames_in_sweep = 0;  ///< 0: not known before the sweep ends
  double angle_deg = 0;               ///< measured motor angle
  SweepDirection direction = SweepDirection::kForward;
  PixelFormat format = PixelFormat::kGrey8;
  bool invalid = false;  ///< the probe marks the pixels as unusable
  std::uint32_t geometry_revision = 0;
  std::uint32_t payload_bytes = 0;   ///< columns x rows; at most kMostPayloadBytes
  std::uint32_t payload_crc32c = 0;  ///< of the pixels

  bool operator==(const FrameHeader&) const = default;
};
inline constexpr std::size_t kFrameHeaderBytes = 64;  ///< of this version; later minor versions may be longer
inline constexpr std::size_t kMostFrameHeaderBytes =
    256;  ///< longest header that a reader must be able to skip
inline constexpr std::uint32_t kMostPayloadBytes = 4096 * 4096;
inline constexpr std::array<std::uint8_t, 4> kMagic = {'F', 'L', 'P', 'F'};

std::array<std::uint8_t, kIdentityBytes> encode(const Identity& identity);
std::array<std::uint8_t, kCapabilitiesBytes> encode(const Capabilities& capabilities);
std::array<std::uint8_t, kGeometryBytes> encode(const Geometry& geometry);
std::array<std::uint8_t, kSettingsBytes> encode(const Settings& settings);
std::array<std::uint8_t, kFrameHeaderBytes> encode(const FrameHeader& header);

// Decoders of blocks from a probe. kBadInput: too short, of another major version, or with a value out of its
// range. Longer blocks are accepted: later minor versions append fields.
Result<Identity> decode_identity(std::span<const std::uint8_t> block);
Result<Capabilities> decode_capabilities(std::span<const std::uint8_t> block);
Result<Geometry> decode_geometry(std::span<const std::uint8_t> block);
Result<Settings> decode_settings(std::span<const std::uint8_t> block);

/// Classification of the bytes at the front of a buffer.
enum class HeaderCheck : std::uint8_t {
  kHeader,    ///< a whole valid header
  kMore,      ///< possibly the beginning of one: more bytes are needed
  kNoHeader,  ///< no magic number, or no valid header after it: a wrong checksum or length
};
/// Reads a header at the front of `bytes`. On kHeader fills `header` and `header_bytes`, its length on the
/// wire. Allocates nothing.
HeaderCheck read_header(std::span<const std::uint8_t> bytes, FrameHeader& header, std::size_t& header_bytes);

}  // namespace fanlight::probe
