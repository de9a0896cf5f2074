// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/frame_parser.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

using probe::HeaderCheck;

FrameParser::Event FrameParser::next(std::span<const std::uint8_t>& bytes) {
  if (std::exchange(at_transfer_start_, false)) {
    probe::FrameHeader begun;
    std::size_t header_bytes = 0;
    if (probe::read_header(bytes, begun, header_bytes) == HeaderCheck::kHeader) {
      // The search below finds the new header; the frame before it is cut.
      if (reset()) return Event::kCut;
    }
  }
  if (held_begin_ < held_end_) {
    auto held = std::span<const std::uint8_t>(held_).first(held_end_).subspan(held_begin_);
    const Event event = use(held);
    held_begin_ = held_end_ - held.size();
    if (event != Event::kMore) return event;
  }
  return use(bytes);
}

FrameParser::Event FrameParser::use(std::span<const std::uint8_t>& bytes) {
  if (in_frame_) return read_pixels(bytes);
  return find_frame(bytes) ? Event::kFrame : Event::kMore;
}

bool FrameParser::reset() {
  bytes_skipped_ += std::exchange(kept_bytes_, 0) + held_end_ - std::exchange(held_begin_, held_end_);
  destination_ = {};
  return std::exchange(in_frame_, false);
}

void FrameParser::begin_frame() {
  in_frame_ = true;
  destination_ = {};
  pixels_left_ = header_.payload_bytes;
  crc_ = {};
}

bool FrameParser::find_frame(std::span<const std::uint8_t>& bytes) {
  if (kept_bytes_ > 0 && find_frame_from_kept(bytes)) return true;
  while (!bytes.empty()) {
    const auto candidate = std::ranges::find(bytes, probe::kMagic[0]);
    const auto passed = static_cast<std::size_t>(candidate - bytes.begin());
    bytes_skipped_ += passed;
    bytes = bytes.subspan(passed);
    std::size_t header_bytes = 0;
    switch (probe::read_header(bytes, header_, header_bytes)) {
      case HeaderCheck::kHeader:
        bytes = bytes.subspan(header_bytes);
        begin_frame();
        return true;
      case HeaderCheck::kMore:
        std::ranges::copy(bytes, kept_.begin());
        kept_bytes_ = bytes.size();
        bytes = {};
        return false;
      case HeaderCheck::kNoHeader:
        if (!bytes.empty()) {
          ++bytes_skipped_;
          bytes = bytes.subspan(1);
        }
        break;
    }
  }
  return false;
}

bool FrameParser::find_frame_from_kept(std::span<const std::uint8_t>& bytes) {
  // The kept bytes and those after them, enough for a header that begins with the last kept byte.
  std::array<std::uint8_t, 2 * probe::kMostFrameHeaderBytes> window;
  std::ranges::copy(std::span(kept_).first(kept_bytes_), window.begin());
  const auto added = bytes.first(std::min(bytes.size(), window.size() - kept_bytes_));
  std::ranges::copy(added, window.begin() + static_cast<std::ptrdiff_t>(kept_bytes_));
  const auto joined = std::span<const std::uint8_t>(window).first(kept_bytes_ + added.size());

  for (std::size_t begin = 0; begin < kept_bytes_; ++begin) {
    const auto candidate = joined.subspan(begin);
    std::size_t header_bytes = 0;
    switch (probe::read_header(candidate, header_, header_bytes)) {
      case HeaderCheck::kHeader: {
        bytes_skipped_ += begin;
        const std::size_t end = begin + header_bytes;
        begin_frame();
        // The beginning of an apparent longer header may have held back this one and the bytes after it.
        if (end < kept_bytes_) {
          held_ = kept_;
          held_begin_ = end;
          held_end_ = kept_bytes_;
        } else {
          bytes = bytes.subspan(end - kept_bytes_);
        }
        kept_bytes_ = 0;
        return true;
      }
      case HeaderCheck::kMore:  // the window holds all bytes so far
        bytes_skipped_ += begin;
        std::ranges::copy(candidate, kept_.begin());
        kept_bytes_ = candidate.size();
        bytes = {};
        return false;
      case HeaderCheck::kNoHeader:
        break;
    }
  }
  bytes_skipped_ += std::exchange(kept_bytes_, 0);
  return false;
}

FrameParser::Event FrameParser::read_pixels(std::span<const std::uint8_t>& bytes) {
  const auto pixels = bytes.first(std::min<std::size_t>(bytes.size(), pixels_left_));
  bytes = bytes.subspan(pixels.size());
  pixels_left_ -= static_cast<std::uint32_t>(pixels.size());
  crc_.add(pixels);
  if (!destination_.empty()) {
    std::ranges::copy(pixels, destination_.begin());
    destination_ = destination_.subspan(pixels.size());
  }
  if (pixels_left_ > 0) return Event::kMore;
  in_frame_ = false;
  destination_ = {};
  return crc_.value() == header_.payload_crc32c ? Event::kWhole : Event::kDamaged;
}

}  // namespace fanlight
