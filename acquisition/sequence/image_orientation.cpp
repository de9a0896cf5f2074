// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/image_orientation.hpp"

#include <algorithm>
#include <cstddef>

namespace fanlight {

namespace {

// Side of a square of pixels that is copied at a time, so that its lines stay in the first-level cache.
// Copying whole columns of a large frame would evict each line before its next use.
constexpr std::uint32_t kTileSide = 16;

}  // namespace

std::optional<ImageOrientation> ImageOrientation::from_letters(std::string_view letters) {
  if (letters.size() == 3 && (letters[2] == 'A' || letters[2] == 'D')) letters.remove_suffix(1);
  if (letters.size() != 2) return std::nullopt;
  const bool lines_in_rows = letters[0] == 'F' || letters[0] == 'N';
  const char lateral = letters[lines_in_rows ? 1 : 0];
  const char depth = letters[lines_in_rows ? 0 : 1];
  if ((lateral != 'M' && lateral != 'U') || (depth != 'F' && depth != 'N')) return std::nullopt;
  return ImageOrientation{
      .lines_in_rows = lines_in_rows, .towards_unmarked = lateral == 'U', .towards_near = depth == 'N'};
}

void arrange_frame(std::span<const std::uint8_t> image, ImageOrientation orientation, FrameSize size,
                   std::span<std::uint8_t> frame) {
  const auto [columns, rows] = size;
  // Distance in the image to the next column and the next row of the frame.
  std::ptrdiff_t to_column = orientation.lines_in_rows ? rows : 1;
  std::ptrdiff_t to_row = orientation.lines_in_rows ? 1 : columns;
  std::ptrdiff_t first = 0;
  if (orientation.towards_unmarked) {
    first += (columns - 1) * to_column;
    to_column = -to_column;
  }
  if (orientation.towards_near) {
    first += (rows - 1) * to_row;
    to_row = -to_row;
  }
  for (std::uint32_t top = 0; top < rows; top += kTileSide) {
    for (std::uint32_t left = 0; left < columns; left += kTileSide) {
      const std::uint32_t right = std::min(left + kTileSide, columns);
      for (std::uint32_t row = top; row < std::min(top + kTileSide, rows); ++row) {
        const std::uint8_t* const from = image.data() + first + row * to_row;
        std::uint8_t* const to = frame.data() + std::size_t{row} * columns;
        for (std::uint32_t column = left; column < right; ++column) to[column] = from[column * to_column];
      }
    }
  }
}

}  // namespace fanlight
