// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "proto/base/result.hpp"

namespace fanlight {

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
};

}  // namespace fanlight
