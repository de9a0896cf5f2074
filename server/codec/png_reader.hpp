// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

struct RgbPicture {
  std::uint32_t width = 0;        ///< pixels
  std::uint32_t height = 0;       ///< pixels
  std::vector<std::uint8_t> rgb;  ///< height x width x 3, row major, sRGB
};

inline constexpr std::uint32_t kMostPngSide = 4096;  ///< pixels

/// Reads a PNG file in memory; what is transparent is black. kBadInput: it is damaged, no PNG, or has a side
/// of more than kMostPngSide.
Result<RgbPicture> read_png(std::span<const std::uint8_t> file);

}  // namespace fanlight
