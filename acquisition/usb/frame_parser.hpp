// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "proto/base/crc32c.hpp"
#include "proto/model/probe_protocol.hpp"

namespace fanlight {

/// Parses the bytes of a probe's bulk pipe into frames (proto/usb_probe.md), however they are divided, and
/// finds the next frame after damaged or foreign bytes. Independent of the bus: bytes in, frames or faults
/// out.
///
/// Life of a frame: kFrame -> take_pixels(), or not -> kWhole, kDamaged or kCut. One thread. Allocates
/// nothing.
class FrameParser {
 public:
  enum class Event : std::uint8_t {
    kMore,     ///< all bytes were used
    kFrame,    ///< a header was read, see header(); its pixels come next
    kWhole,    ///< all its pixels have arrived, their checksum is right
    kDamaged,  ///< all its pixels have arrived, their checksum is wrong
    kCut,      ///< another frame began before its last pixel
  };

  /// The next bytes are the first of a transfer, where a frame is expected to begin.
  void begin_transfer() { at_transfer_start_ = true; }

  /// Consumes bytes from the front of `bytes` up to the next event, and shortens `bytes`. Call again until
  /// kMore.
  Event next(std::span<const std::uint8_t>& bytes);

  /// The frame of the last kFrame.
  const probe::FrameHeader& header() const { return header_; }

  /// Right after kFrame: the pixels are written to `to`, which holds header().payload_bytes and must live
  /// until the end of the frame. Without this call they are skipped.
  void take_pixels(std::span<std::uint8_t> to) { destination_ = to; }

  /// Whether a frame has begun and not ended.
  bool in_frame() const { return in_frame_; }

  /// Drops the frame begun: the next bytes do not continue the previous ones. True where a frame was cut.
  bool reset();

  /// Bytes so far that belong to no frame.
  std::uint64_t bytes_skipped() const { return bytes_skipped_; }

 private:
  Event use(std::span<const std::uint8_t>& bytes);
  bool find_frame(std::span<const std::uint8_t>& bytes);
  bool find_frame_from_kept(std::span<const std::uint8_t>& bytes);
  void begin_frame();
  Event read_pixels(std::span<const std::uint8_t>& bytes);

  probe::FrameHeader header_;
  bool in_frame_ = false;
  bool at_transfer_start_ = false;
  std::span<std::uint8_t> destination_;  // of the pixels to come; empty: they are skipped
  std::uint32_t pixels_left_ = 0;        // bytes
  Crc32c crc_;
  // Last bytes so far, where they may be the beginning of a header.
  std::array<std::uint8_t, probe::kMostFrameHeaderBytes> kept_{};
  std::size_t kept_bytes_ = 0;
  // Bytes that were kept for an apparent header and follow the real one found among them. Parsed before any
  // new bytes.
  std::array<std::uint8_t, probe::kMostFrameHeaderBytes> held_{};
  std::size_t held_begin_ = 0;
  std::size_t held_end_ = 0;
  std::uint64_t bytes_skipped_ = 0;
};

}  // namespace fanlight
