// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

/// Loops over the pixels of a row, for pass 0 on a processor (frame_preparer.hpp). Each is compiled for
/// several instruction sets by Highway, and runs on the best one that the processor has.
///
/// Rows begin at column 0. kRowPadding elements before and behind the `columns` of each row can be read. They
/// are 0 in rows of grey levels and sums, so that a window beyond the frame's border adds nothing. `radius`:
/// of the window along the row, at most 3.
namespace fanlight::row_kernels {

/// Bytes of the widest vector that is used.
constexpr std::size_t kVectorBytes = 64;
/// At least a vector of bytes and a radius, which the last step of a loop reads beyond a row.
constexpr std::size_t kRowPadding = 2 * kVectorBytes;

/// Sums of a column over the rows and frames of a window.
struct ColumnSums {
  std::uint16_t* grey = nullptr;
  std::uint32_t* squares = nullptr;  ///< of grey levels; null where they are not needed
  std::uint16_t* scanned = nullptr;  ///< pixels above 0; null where all pixels are scanned
};
/// Moves the sums down by a row: adds the pixels of one row and subtracts those of another.
void slide(const ColumnSums& sums, const std::uint8_t* entering, const std::uint8_t* leaving,
           std::size_t columns);

/// The lines a I + b of the guided filter, in units of 1/65535, and of 255/65535 grey levels.
struct Lines {
  std::uint32_t* a = nullptr;
  std::uint32_t* b = nullptr;
};
/// What guided_fit.comp knows of a row's windows.
struct Windows {
  const std::uint32_t* across = nullptr;  ///< pixels of each window along the row
  std::uint32_t rest = 1;                 ///< pixels of the windows in the other directions
  std::size_t radius = 0;
  std::size_t columns = 0;
};
/// Fits the lines of guided_fit.comp, and adds them to `lines`.
void add_lines(const ColumnSums& sums, const Windows& windows, float noise, float levels, const Lines& lines);

/// Adds and subtracts the lines of two rows.
void slide_lines(const Lines& sums, const Lines& entering, const Lines& leaving, std::size_t columns);

/// Applies the mean of the lines, as guided_apply.comp does. `sums`: of the columns. With `keeps_zero`,
/// pixels of 0 stay 0, and others stay above 0.
void apply_lines(const Lines& sums, const Windows& windows, const std::uint8_t* grey, bool keeps_zero,
                 std::uint8_t* filtered);

/// The mean of box.comp; keeps zeros where `sums` count what is scanned.
void take_means(const ColumnSums& sums, const Windows& windows, const std::uint8_t* grey,
                std::uint8_t* filtered);

/// The windows of a row's medians.
struct MedianRows {
  const std::uint8_t* const* rows = nullptr;  ///< those of the windows, in all their frames
  std::size_t count = 0;                      ///< of the rows; at most 21
  const std::uint8_t* present = nullptr;      ///< pixels of each window that lie in the volume
  std::size_t radius = 0;
  std::size_t columns = 0;
};
/// The median of median.comp. With `keeps_zero`, as above, and zeros are not part of the windows.
void take_medians(const MedianRows& window, const std::uint8_t* grey, bool keeps_zero,
                  std::uint8_t* filtered);

using FourRows = std::array<const std::uint8_t*, 4>;
using FourRowsOfBounds = std::array<const std::uint16_t*, 4>;

/// Words of four rows, the first in the lowest byte (fan_volume.h). Writes up to 16 words beyond the columns.
void pack(const FourRows& rows, std::size_t columns, std::uint32_t* words);

/// Bounds of the grey levels in each block of four columns and the four rows: 255 - minimum in the low byte
/// and maximum in the high one, so that both grow where blocks are joined.
void find_bounds(const FourRows& rows, std::size_t columns, std::uint16_t* bounds);

/// The bounds of 4 x 4 blocks each, as neighbour_min_max.comp packs them. `rows`: four rows of find_bounds(),
/// 0 behind the last block.
void join_bounds(const FourRowsOfBounds& rows, std::size_t blocks, std::uint32_t* joined);

}  // namespace fanlight::row_kernels
