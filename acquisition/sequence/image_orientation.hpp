// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace fanlight {

/// Directions of the two axes of a stored image relative to the transducer, as given by
/// UltrasoundImageOrientation (PLUS, docs/UltrasoundImageOrientation.md): the first letter is the direction
/// of the image's x axis, the second of its y axis. M and U: to the marked and the unmarked side; F and N:
/// far from and near to the probe.
struct ImageOrientation {
  bool lines_in_rows = false;     ///< x is depth: each row of the image is a scan line
  bool towards_unmarked = false;  ///< lateral axis; false: towards the marked side
  bool towards_near = false;      ///< depth axis; false: away from the probe

  /// MF, MN, UF, UN, FM, FU, NM or NU; nullopt for others. A third letter, A or D, is accepted and ignored:
  /// it is the direction of a z axis, which a 2D image does not have. The elevation of a frame follows from
  /// its motor angle and the probe's own axes, which do not depend on how the image is stored.
  static std::optional<ImageOrientation> from_letters(std::string_view letters);

  bool operator==(const ImageOrientation&) const = default;
};

/// Size of a frame in Fanlight's axis order: columns ascend towards the marked side, rows away from the
/// probe.
struct FrameSize {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
};

/// Copies a stored image into the axis order of a frame of `size`. Both are columns x rows bytes and must not
/// overlap. An image with scan lines in rows is `size.rows` wide. Allocates nothing.
void arrange_frame(std::span<const std::uint8_t> image, ImageOrientation orientation, FrameSize size,
                   std::span<std::uint8_t> frame);

}  // namespace fanlight
