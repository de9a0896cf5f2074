// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/replay/frame_reader.hpp"
#include "acquisition/replay/header_lines.hpp"
#include "acquisition/replay/inflater.hpp"
#include "acquisition/replay/sequence_pixels.hpp"
#include "acquisition/sequence/image_orientation.hpp"
#include "acquisition/sequence/pixel_values.hpp"

namespace fanlight {

/// The file behind its header, and where the reading is.
struct SequencePixels::Reading {
  static constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();
  File file;
  NamedFile from;
  ImageOrientation orientation;
  std::uint32_t columns = 0;  // after arranging
  std::uint32_t rows = 0;
  std::uint64_t frames = 0;
  std::uint64_t next = 0;  // frame
  bool transposed = false;
  PixelFormat format;
  std::optional<GreyLevels> levels;             // absent: the stored values are grey levels
  std::optional<std::uint32_t> unscanned_code;  // see mark_unscanned()
  std::optional<Inflater> inflater;             // absent: plain pixels
  std::vector<std::uint8_t> stored;             // a frame as in the file, where it is not grey levels
  std::vector<std::uint8_t> in_order;           // a frame of grey levels in the file's axis order
  long first_pixel = 0;                         // offset in the file
  std::uint64_t compressed_bytes = 0;
  bool gzip = false;
  struct stat opened_as {};
  std::unique_ptr<FrameReader> reader;  // then there is no file

  /// Of the file.
  std::uint64_t frame_bytes() const { return std::uint64_t{columns} * rows * format.bytes; }
  std::uint64_t all_bytes() const { return frame_bytes() * frames; }
  Result<void> read_stored(std::span<std::uint8_t> to) {
    if (reader) return reader->read(next, to);
    return inflater ? read_compressed(to) : read_plain(to);
  }
  Result<void> go_to(std::uint64_t frame);
  Result<void> read_plain(std::span<std::uint8_t> to);
  Result<void> read_compressed(std::span<std::uint8_t> to);
  void judge_layout(std::span<const std::uint8_t> frame);
};

}  // namespace fanlight
