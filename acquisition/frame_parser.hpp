#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "proto/crc32c.hpp"
#include "proto/probe_protocol.hpp"

namespace fanlight {

/// Cuts the bytes of a probe's bulk pipe into frames (proto/usb_probe.md), however they are divided, and
/// finds the next frame after whatever came between. Knows of no bus: bytes in, frames or reasons out.
///
/// Life of a frame: kFrame -> take_pixels(), or not -> kWhole, kDamaged or kCut. One thread. Allocates
/// nothing.
class FrameParser {
 public:
  enum class Event : std::uint8_t {
    kMore,     ///< all bytes were used
    kFrame,    ///< header() is that of a frame whose pixels come next
    kWhole,    ///< all its pixels have come, and their checksum is right
    kDamaged,  ///< all have come, and their checksum is wrong
    kCut,      ///< another frame began before its last pixel
  };

  /// The bytes given next are the first of a transfer, where a frame is expected to begin.
  void begin_transfer() { at_transfer_start_ = true; }

  /// Uses bytes from the front of `bytes`, which it shortens, up to the next event. Call again until kMore.
  Event next(std::span<const std::uint8_t>& bytes);

  /// The frame of the last kFrame.
  const probe::FrameHeader& header() const { return header_; }

  /// Right after kFrame: writes its pixels to `to`, which holds header().payload_bytes and must live until
  /// the frame's end. Without this call they are passed over.
  void take_pixels(std::span<std::uint8_t> to) { destination_ = to; }

  /// Whether a frame has begun and not ended.
  bool in_frame() const { return in_frame_; }

  /// Forgets what has begun: the bytes to come do not follow on those before. True where a frame was cut.
  bool reset();

  /// Bytes so far that belonged to no frame.
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
  std::span<std::uint8_t> destination_;  // of the frame's pixels to come; empty: passed over
  std::uint32_t pixels_left_ = 0;        // bytes
  Crc32c crc_;
  // The end of the bytes so far where it may be the beginning of a header.
  std::array<std::uint8_t, probe::kMostFrameHeaderBytes> kept_{};
  std::size_t kept_bytes_ = 0;
  // Bytes that were kept for a header that was none, and come after one that was found among them: used
  // before any others.
  std::array<std::uint8_t, probe::kMostFrameHeaderBytes> held_{};
  std::size_t held_begin_ = 0;
  std::size_t held_end_ = 0;
  std::uint64_t bytes_skipped_ = 0;
};

}  // namespace fanlight
