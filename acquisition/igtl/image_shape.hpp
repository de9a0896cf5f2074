// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "acquisition/igtl/igtl_image.hpp"
#include "acquisition/sequence/pixel_values.hpp"

namespace fanlight {

/// What images of one geometry have in common.
struct ImageShape {
  std::array<std::uint16_t, 3> size{};
  PixelFormat format;
  std::array<double, 2> pixel_mm{};
  std::uint64_t described = 0;  ///< checksum of the metadata whose names begin with Fanlight

  /// Precondition: why_no_frame(image.body) is empty.
  static ImageShape of(const IgtlImage& image);

  /// Whether both may be of one geometry. Pixel sizes differ in the last bits of a matrix.
  bool matches(const ImageShape& other) const;
};

}  // namespace fanlight
