// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace fanlight {

/// Size of a picture in pixels.
struct PictureSize {
  std::uint32_t width = 512;
  std::uint32_t height = 512;

  constexpr std::uint64_t pixels() const { return std::uint64_t{width} * height; }

  bool operator==(const PictureSize&) const = default;
};

/// The largest sizes in which displays show the main view; absent: as usual.
struct WantedSizes {
  std::optional<PictureSize> of_surfaces;  ///< that displays light themselves
  std::optional<PictureSize> of_pictures;  ///< that the server has lit

  bool operator==(const WantedSizes&) const = default;
};

}  // namespace fanlight
