#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace fanlight {

/// Which way the two axes of a stored image run across the transducer, as UltrasoundImageOrientation says it
/// (PLUS, docs/UltrasoundImageOrientation.md): the first letter is where the image's x axis points, the
/// second its y axis. M and U: to the marked and the unmarked side; F and N: far from and near to the probe.
struct ImageOrientation {
  bool lines_in_rows = false;     ///< x runs in depth: each row of the image is a scan line
  bool towards_unmarked = false;  ///< the lateral axis, else to the marked side
  bool towards_near = false;      ///< the axis in depth, else away from the probe

  /// MF, MN, UF, UN, FM, FU, NM or NU; nullopt for others. A third letter, A or D, is taken and says nothing:
  /// it is the direction of a z axis that a 2D image does not have. Where a frame lies in elevation follows
  /// from its motor angle and the probe's own axes, which no way of storing the image turns.
  static std::optional<ImageOrientation> from_letters(std::string_view letters);

  bool operator==(const ImageOrientation&) const = default;
};

/// The size of a frame as all rooms hold it: columns grow towards the marked side, rows away from the probe.
struct FrameSize {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
};

/// Writes the pixels of a stored image in the order of a frame of `size`; neither image nor frame, columns x
/// rows bytes each, may overlap the other. An image of scan lines in rows is `size.rows` wide. Allocates
/// nothing.
void arrange_frame(std::span<const std::uint8_t> image, ImageOrientation orientation, FrameSize size,
                   std::span<std::uint8_t> frame);

}  // namespace fanlight
