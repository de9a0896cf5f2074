// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "renderer/parameters/view_frame.hpp"

namespace fanlight {

/// Pixels along a side of the tiles that work groups of the shaders compute.
inline constexpr int kTileSide = 8;

/// A rectangle of pixels of a picture: columns left to right - 1, rows top to bottom - 1. Empty where right
/// <= left.
struct PixelRect {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;

  static PixelRect whole(PictureSize size) {
    return {.right = static_cast<int>(size.width), .bottom = static_cast<int>(size.height)};
  }

  bool empty() const { return right <= left || bottom <= top; }
  int pixels() const { return empty() ? 0 : (right - left) * (bottom - top); }

  /// The smallest rectangle around both.
  PixelRect united(const PixelRect& other) const {
    if (empty() || other.empty()) return empty() ? other : *this;
    return {std::min(left, other.left), std::min(top, other.top), std::max(right, other.right),
            std::max(bottom, other.bottom)};
  }

  /// With this many pixels more on each side, moved out to whole tiles, and cut at the picture's borders,
  /// where the last tiles end.
  PixelRect grown(int across, int down, PictureSize size) const {
    if (empty()) return *this;
    const auto below = [](int at) { return std::max(at, 0) / kTileSide * kTileSide; };
    const auto above = [](int at, std::uint32_t most) {
      const int last_tile_end = (static_cast<int>(most) + kTileSide - 1) / kTileSide * kTileSide;
      return std::min((at + kTileSide - 1) / kTileSide * kTileSide, last_tile_end);
    };
    return {below(left - across), below(top - down), above(right + across, size.width),
            above(bottom + down, size.height)};
  }

  bool operator==(const PixelRect&) const = default;
};

}  // namespace fanlight
