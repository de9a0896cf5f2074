// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "acquisition/sequence/unscanned.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// What a reader found out about pixels that were not scanned.
struct UnscannedPixels {
  std::optional<std::uint32_t> code;  ///< the bits of the stored value that only they have
  std::string note;                   ///< a sentence for the user; empty: there is nothing to say
};

/// Frames that a library reads, or that are made from others: in any order, each as rows x columns stored
/// values of the PixelFormat that comes with it. One thread.
class FrameReader {
 public:
  FrameReader() = default;
  FrameReader(const FrameReader&) = delete;
  FrameReader& operator=(const FrameReader&) = delete;
  virtual ~FrameReader() = default;

  /// kBadInput: the frame cannot be read.
  virtual Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to) = 0;

  /// From now on read() gives pixels that were not scanned a value of their own. Precondition: `wanted` is
  /// not kNone.
  virtual UnscannedPixels mark_unscanned(Unscanned wanted) {
    (void)wanted;
    return {};
  }
};

}  // namespace fanlight
