// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// Size of a picture in pixels.
struct PictureSize {
  std::uint32_t width = 512;
  std::uint32_t height = 512;

  constexpr std::uint64_t pixels() const { return std::uint64_t{width} * height; }

  bool operator==(const PictureSize&) const = default;
};

}  // namespace fanlight
