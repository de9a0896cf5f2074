// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/frame_preparer.hpp"

#include <algorithm>
#include <array>

#include "shaders/bindings.h"
#include "shaders/prepare_constants.h"

namespace fanlight {

namespace {

// row_kernels::pack() writes whole vectors of words: what follows the columns in a packed row has room for
// one.
static_assert(FANLIGHT_PACKED_STRIDE(64U) - 64U >= row_kernels::kVectorBytes / sizeof(std::uint32_t));

constexpr std::size_t kBlock = FANLIGHT_BLOCK;
static_assert(FANLIGHT_BLOCK == 4 && FANLIGHT_BLOCKS_IN_BOUND == 4,
              "row_kernels::find_bounds and join_bounds");

constexpr std::size_t blocks_along(std::size_t pixels) {
  return (pixels + kBlock - 1) / kBlock;
}

}  // namespace

FramePreparer::FramePreparer(std::uint32_t columns)
    : columns_(columns),
      filtered_stride_(columns + row_kernels::kRowPadding),
      sums_(kMostAcross, Sums(columns)),
      line_rows_(kMostSide + 2, LineRow(columns)),
      line_sums_(columns),
      across_(columns),
      present_(columns),
      pixel_rows_(std::size_t{kMostSide} * kMostAcross, PaddedRow<std::uint8_t>(columns)),
      middle_(columns),
      zeros_(columns),
      filtered_(filtered_stride_ * kFilteredRows),
      bounds_stride_(blocks_along(columns) + row_kernels::kRowPadding),
      block_bounds_(bounds_stride_ * FANLIGHT_BLOCKS_IN_BOUND),
      joined_(bounds_stride_) {}

void FramePreparer::prepare(const StagedFrames& staged, const Scene::Speckle& options, std::uint32_t frame,
                            const Prepared& to) {
  staged_ = staged;
  options_ = options;
  to_ = to;
  radius_ = options.size / 2;
  for (int column = 0; column < static_cast<int>(columns_); ++column) {
    const int last = std::min(column + radius_, static_cast<int>(columns_) - 1);
    across_.begin()[column] = static_cast<std::uint32_t>(last - std::max(column - radius_, 0) + 1);
  }
  switch (options.filter) {
    case SpeckleFilter::kNone:
      copy(frame);
      break;
    case SpeckleFilter::kBox:
      filter_box(frame);
      break;
    case SpeckleFilter::kMedian:
      filter_median(frame);
      break;
    case SpeckleFilter::kGuided:
      filter_guided(frame);
      break;
  }
}

FramePreparer::FrameRange FramePreparer::window(std::uint32_t frame) const {
  const auto radius = static_cast<std::uint32_t>(options_.across / 2);
  return {.first = frame - std::min(frame, radius), .last = std::min(frame + radius, staged_.frames - 1)};
}

/// Rows of the frame in the window around a row.
std::uint32_t FramePreparer::rows_in_window(int row) const {
  const int last = std::min(row + radius_, rows() - 1);
  return static_cast<std::uint32_t>(last - std::max(row - radius_, 0) + 1);
}

row_kernels::Windows FramePreparer::windows(int row, FrameRange frames) {
  return {.across = across_.begin(),
          .rest = rows_in_window(row) * frames.count(),
          .radius = static_cast<std::size_t>(radius_),
          .columns = columns_};
}

row_kernels::ColumnSums FramePreparer::column_sums(Sums& sums, Squares squares) const {
  return {.grey = sums.grey.begin(),
          .squares = squares == Squares::kSummed ? sums.squares.begin() : nullptr,
          .scanned = staged_.zero_is_unscanned ? sums.scanned.begin() : nullptr};
}

/// A row of a frame with zeros at both ends; only zeros outside the frame.
const std::uint8_t* FramePreparer::padded(PaddedRow<std::uint8_t>& to, std::uint32_t frame, int row) {
  if (row < 0 || row >= rows()) return zeros_.begin();
  std::copy_n(staged_.row(frame, static_cast<std::uint32_t>(row)), columns_, to.begin());
  return to.begin();
}

/// Moves the windows of the sums to `row`, from the row before.
void FramePreparer::slide(Sums& sums, Squares squares, FrameRange frames, int row) {
  for (std::uint32_t frame = frames.first; frame <= frames.last; ++frame) {
    row_kernels::slide(column_sums(sums, squares), padded(pixel_rows_[0], frame, row + radius_),
                       padded(pixel_rows_[1], frame, row - radius_ - 1), columns_);
  }
}

/// Moves the windows of empty sums to the row before the first one.
void FramePreparer::start(Sums& sums, Squares squares, FrameRange frames) {
  sums.grey.clear();
  sums.squares.clear();
  sums.scanned.clear();
  for (int row = -radius_; row < 0; ++row) slide(sums, squares, frames, row);
}

void FramePreparer::copy(std::uint32_t frame) {
  for (std::uint32_t row = 0; row < staged_.rows; ++row) {
    std::copy_n(staged_.row(frame, row), columns_, filtered_row(row));
    finish_row(row);
  }
}

void FramePreparer::filter_box(std::uint32_t frame) {
  const FrameRange frames = window(frame);
  Sums& sums = sums_[0];
  start(sums, Squares::kLeftOut, frames);
  for (int row = 0; row < rows(); ++row) {
    slide(sums, Squares::kLeftOut, frames, row);
    row_kernels::take_means(column_sums(sums, Squares::kLeftOut), windows(row, frames),
                            padded(middle_, frame, row), filtered_row(static_cast<std::uint32_t>(row)));
    finish_row(static_cast<std::uint32_t>(row));
  }
}

void FramePreparer::filter_median(std::uint32_t frame) {
  const FrameRange frames = window(frame);
  std::array<const std::uint8_t*, std::size_t{kMostSide} * kMostAcross> window_rows{};
  for (int row = 0; row < rows(); ++row) {
    std::size_t count = 0;
    for (std::uint32_t each = frames.first; each <= frames.last; ++each) {
      for (int near = std::max(row - radius_, 0); near <= std::min(row + radius_, rows() - 1);
           ++near, ++count) {
        window_rows[count] = padded(pixel_rows_[count], each, near);
      }
    }
    for (std::uint32_t column = 0; column < columns_; ++column)
      present_.begin()[column] = static_cast<std::uint8_t>(across_.begin()[column] * count);
    row_kernels::take_medians({.rows = window_rows.data(),
                               .count = count,
                               .present = present_.begin(),
                               .radius = static_cast<std::size_t>(radius_),
                               .columns = columns_},
                              padded(middle_, frame, row), staged_.zero_is_unscanned,
                              filtered_row(static_cast<std::uint32_t>(row)));
    finish_row(static_cast<std::uint32_t>(row));
  }
}

/// The lines of a row of a frame, summed over the frames of its window.
void FramePreparer::fit_row(FrameRange frames, int row, LineRow& to) {
  to.a.clear();
  to.b.clear();
  for (std::uint32_t each = frames.first; each <= frames.last; ++each) {
    Sums& sums = sums_[each - frames.first];
    slide(sums, Squares::kSummed, window(each), row);
    row_kernels::add_lines(column_sums(sums, Squares::kSummed), windows(row, window(each)),
                           static_cast<float>(options_.noise), static_cast<float>(options_.levels),
                           to.lines());
  }
}

void FramePreparer::filter_guided(std::uint32_t frame) {
  const FrameRange frames = window(frame);
  for (std::uint32_t each = frames.first; each <= frames.last; ++each)
    start(sums_[each - frames.first], Squares::kSummed, window(each));
  // A ring of the lines in the rows of a window, and of the row that leaves it.
  const int side = 2 * radius_ + 1;
  const auto slot = [&](int row) -> LineRow& {
    return line_rows_[static_cast<std::size_t>(row % (side + 1))];
  };
  LineRow& no_lines = line_rows_.back();
  line_sums_.a.clear();
  line_sums_.b.clear();
  for (int newest = 0; newest < rows() + radius_; ++newest) {
    if (newest < rows()) fit_row(frames, newest, slot(newest));
    row_kernels::slide_lines(line_sums_.lines(), (newest < rows() ? slot(newest) : no_lines).lines(),
                             (newest >= side ? slot(newest - side) : no_lines).lines(), columns_);
    const int row = newest - radius_;
    if (row < 0) continue;
    row_kernels::apply_lines(line_sums_.lines(), windows(row, frames), padded(middle_, frame, row),
                             staged_.zero_is_unscanned, filtered_row(static_cast<std::uint32_t>(row)));
    finish_row(static_cast<std::uint32_t>(row));
  }
}

/// Writes what a filtered row completes.
void FramePreparer::finish_row(std::uint32_t row) {
  const std::uint32_t last = staged_.rows - 1;
  // A packed row holds the first row of the next one too.
  constexpr std::uint32_t kInPackedRow = 3;
  if (row > 0 && row % kInPackedRow == 0) write_packed(row / kInPackedRow - 1);
  if (row == last) write_packed(row / kInPackedRow);
  if (row == last || row % FANLIGHT_BLOCK == FANLIGHT_BLOCK - 1) write_bounds(row / FANLIGHT_BLOCK);
}

void FramePreparer::write_packed(std::uint32_t packed_row) {
  const std::uint32_t last = staged_.rows - 1;
  const auto row = [&](std::uint32_t in_word) {
    return filtered_row(std::min(3 * packed_row + in_word, last));
  };
  row_kernels::pack({row(0), row(1), row(2), row(3)}, columns_,
                    to_.packed + std::size_t{packed_row} * FANLIGHT_PACKED_STRIDE(columns_));
}

/// Finds the bounds of a row of blocks, and joins those of the rows of blocks that end with it.
void FramePreparer::write_bounds(std::uint32_t block_row) {
  const std::uint32_t last = staged_.rows - 1;
  const auto row = [&](std::uint32_t in_block) {
    return filtered_row(std::min(FANLIGHT_BLOCK * block_row + in_block, last));
  };
  row_kernels::find_bounds({row(0), row(1), row(2), row(3)}, columns_, bounds_row(block_row));
  constexpr std::uint32_t kJoined = FANLIGHT_BLOCKS_IN_BOUND;
  if (block_row + 1 >= kJoined) join_bounds(block_row + 1 - kJoined);
  if (block_row != last / FANLIGHT_BLOCK) return;
  // There are no blocks behind the last row.
  for (std::uint32_t behind = 1; behind < kJoined; ++behind) {
    std::fill_n(bounds_row(block_row + behind), bounds_stride_, std::uint16_t{0});
    if (block_row + behind + 1 >= kJoined) join_bounds(block_row + behind + 1 - kJoined);
  }
}

void FramePreparer::join_bounds(std::uint32_t block_row) {
  const std::size_t across = blocks_along(columns_);
  row_kernels::join_bounds({bounds_row(block_row), bounds_row(block_row + 1), bounds_row(block_row + 2),
                            bounds_row(block_row + 3)},
                           across, joined_.data());
  // The kernel writes whole vectors, behind the last block too.
  std::copy_n(joined_.data(), across, to_.bounds + block_row * across);
}

}  // namespace fanlight
