// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/sequence/frame_sequence.hpp"

namespace fanlight {

/// The scanned part of scan-converted frames, as it can be seen in them: where pixels are ever bright.
/// Lengths are in rows; columns count as `column_rows` of them.
struct SectorGuess {
  bool diverges = false;      ///< false: the edges are parallel, as of a flat array
  double face_column = 0;     ///< of the middle between the edges
  double face_row = 0;        ///< first bright row there
  double last_row = 0;        ///< last bright row there
  double apex_row = 0;        ///< where the edges meet, above the face; if it diverges
  double half_angle_deg = 0;  ///< of the edges to their middle; if it diverges
  double lean_deg = 0;        ///< of their middle to the columns of the frame, to the right; if it diverges
  double left_column = 0;     ///< of parallel edges
  double right_column = 0;
};

/// Finds straight edges by the borders of the bright pixels of each row: the line with the most borders
/// within 1.5 pixels, of 400 through two of them. The middle between the edges is where the face is.
/// `brightest`: rows x columns, each pixel's greatest grey level in all frames. `column_rows`: width of a
/// pixel divided by its height. nullopt: nothing is bright, or the borders lie on no line.
std::optional<SectorGuess> guess_sector(std::span<const std::uint8_t> brightest, std::uint32_t columns,
                                        std::uint32_t rows, double column_rows);

/// How far the frames are apart, by the likeness of their speckle. Across the beam, speckle is about as wide
/// between the frames as within them where the aperture is: two frames that are as much alike as two columns
/// at a distance are as far apart. A guess: good to a factor of two.
struct StepGuess {
  double step_columns = 0;  ///< from frame to frame, in columns
  double likeness = 0;      ///< correlation of neighbouring frames
  std::uint32_t row = 0;    ///< where it was measured: the middle of the sector
};

/// Adds up pairs of neighbouring frames. One thread.
class StepGuesser {
 public:
  StepGuesser(std::uint32_t columns, std::uint32_t rows, const SectorGuess& sector);
  void add(std::span<const std::uint8_t> frame, std::span<const std::uint8_t> next);
  /// nullopt: the frames are alike, or have nothing in common.
  std::optional<StepGuess> guess() const;

 private:
  static constexpr std::size_t kMostColumns = 24;
  double likeness(std::span<const std::uint8_t> one, std::span<const std::uint8_t> other,
                  std::size_t shift) const;

  std::uint32_t columns_;
  std::uint32_t first_row_ = 0;
  std::uint32_t end_row_ = 0;
  std::uint32_t first_column_ = 0;
  std::uint32_t end_column_ = 0;
  std::uint32_t pairs_ = 0;
  double between_frames_ = 0;            // sums over the pairs
  std::vector<double> between_columns_;  // by their distance
};

}  // namespace fanlight
