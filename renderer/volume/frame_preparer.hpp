// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "proto/model/scene.hpp"
#include "renderer/volume/row_kernels.hpp"
#include "shaders/bindings.h"

namespace fanlight {

/// Staged frames, in memory of the processor.
struct StagedFrames {
  const std::uint8_t* pixels = nullptr;  ///< frame by ascending angle, row, column
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint32_t row_bytes = 0;  ///< from one row to the next
  std::uint32_t frames = 0;
  bool zero_is_unscanned = false;  ///< as FanGeometry's

  const std::uint8_t* row(std::uint32_t frame, std::uint32_t row) const {
    return pixels + (std::size_t{frame} * rows + row) * row_bytes;
  }
};

/// Pass 0 on a processor: filters single frames, packs them for the gathering of pass 1
/// (shaders/fan_volume.h), and finds the bounds by which rays skip empty space. The same filters as the
/// shaders of pass 0, which GPUs run, with the same windows and roundings; results may be one grey level
/// apart where a driver divides less exactly. Ten times faster than those shaders on lavapipe (decision
/// renderer/016).
///
/// Owns the memory for its rows, which is allocated with it. One thread at a time.
class FramePreparer {
 public:
  explicit FramePreparer(std::uint32_t columns);

  /// Where a prepared frame is written to.
  struct Prepared {
    /// FANLIGHT_PACKED_ROWS rows of FANLIGHT_PACKED_STRIDE words.
    std::uint32_t* packed = nullptr;
    /// A word for each block, as packed_min_max() of blocks.h: row of blocks, block.
    std::uint32_t* bounds = nullptr;
  };
  /// Prepares one frame; `frame`: its index in `staged`. Reads its neighbours too where the filter spans
  /// several. Precondition: the columns are those of the constructor.
  void prepare(const StagedFrames& staged, const Scene::Speckle& options, std::uint32_t frame,
               const Prepared& to);

 private:
  static constexpr std::uint32_t kMostSide = 7;    // pixels, of a window in a frame
  static constexpr std::uint32_t kMostAcross = 3;  // frames of a window
  // A ring: as soon as its last row is filtered, a packed row or a row of blocks is written.
  static constexpr std::uint32_t kFilteredRows = 8;

  // The frames of a window.
  struct FrameRange {
    std::uint32_t first = 0;
    std::uint32_t last = 0;  // of the window too
    std::uint32_t count() const { return last - first + 1; }
  };

  // A row as row_kernels.hpp has it.
  template <typename Value>
  class PaddedRow {
   public:
    explicit PaddedRow(std::size_t columns) : values_(columns + 2 * row_kernels::kRowPadding) {}
    Value* begin() { return values_.data() + row_kernels::kRowPadding; }
    void clear() { std::ranges::fill(values_, Value{}); }

   private:
    std::vector<Value> values_;
  };

  // Over the columns of windows that slide down a frame.
  struct Sums {
    explicit Sums(std::size_t columns) : grey(columns), squares(columns), scanned(columns) {}
    PaddedRow<std::uint16_t> grey;
    PaddedRow<std::uint32_t> squares;
    PaddedRow<std::uint16_t> scanned;
  };
  enum class Squares : std::uint8_t { kLeftOut, kSummed };

  struct LineRow {
    explicit LineRow(std::size_t columns) : a(columns), b(columns) {}
    row_kernels::Lines lines() { return {.a = a.begin(), .b = b.begin()}; }
    PaddedRow<std::uint32_t> a;
    PaddedRow<std::uint32_t> b;
  };

  FrameRange window(std::uint32_t frame) const;
  std::uint32_t rows_in_window(int row) const;
  row_kernels::Windows windows(int row, FrameRange frames);
  row_kernels::ColumnSums column_sums(Sums& sums, Squares squares) const;
  const std::uint8_t* padded(PaddedRow<std::uint8_t>& to, std::uint32_t frame, int row);
  void start(Sums& sums, Squares squares, FrameRange frames);
  void slide(Sums& sums, Squares squares, FrameRange frames, int row);
  void copy(std::uint32_t frame);
  void filter_box(std::uint32_t frame);
  void filter_median(std::uint32_t frame);
  void filter_guided(std::uint32_t frame);
  void fit_row(FrameRange frames, int row, LineRow& to);
  void finish_row(std::uint32_t row);
  void write_packed(std::uint32_t packed_row);
  void write_bounds(std::uint32_t block_row);
  void join_bounds(std::uint32_t block_row);
  int rows() const { return static_cast<int>(staged_.rows); }
  std::uint8_t* filtered_row(std::uint32_t row) {
    return filtered_.data() + row % kFilteredRows * filtered_stride_;
  }
  std::uint16_t* bounds_row(std::uint32_t block_row) {
    return block_bounds_.data() + block_row % FANLIGHT_BLOCKS_IN_BOUND * bounds_stride_;
  }

  std::uint32_t columns_;
  std::size_t filtered_stride_;
  // Of the frame that is prepared.
  StagedFrames staged_;
  Scene::Speckle options_;
  Prepared to_;
  int radius_ = 0;
  std::vector<Sums> sums_;
  std::vector<LineRow> line_rows_;  // the last one stays 0
  LineRow line_sums_;
  PaddedRow<std::uint32_t> across_;  // pixels of each window along the row
  PaddedRow<std::uint8_t> present_;
  std::vector<PaddedRow<std::uint8_t>> pixel_rows_;
  PaddedRow<std::uint8_t> middle_;
  PaddedRow<std::uint8_t> zeros_;
  std::vector<std::uint8_t> filtered_;
  std::size_t bounds_stride_;
  std::vector<std::uint16_t> block_bounds_;  // a ring of rows, with zeros behind the last block
  std::vector<std::uint32_t> joined_;
};

}  // namespace fanlight
