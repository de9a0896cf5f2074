// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/frame_preparer.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>
#include <vector>

#include "shaders/prepare_constants.h"
#include "tests/support/cpu_twin.hpp"

namespace fanlight::test::frame_preparer_tests {
namespace {

struct PreparedFrame {
  std::vector<std::uint32_t> packed;
  std::vector<std::uint32_t> bounds;
  bool operator==(const PreparedFrame&) const = default;
};

constexpr std::uint32_t blocks_along(std::uint32_t pixels) {
  return (pixels + FANLIGHT_BLOCK - 1) / FANLIGHT_BLOCK;
}

// At the ends of vectors of any length, with the radius of a window.
constexpr std::array kWidths = {1U,  2U,  3U,  4U,  5U,  15U, 16U,  17U,  31U,
                                33U, 63U, 64U, 65U, 66U, 67U, 128U, 129U, 150U};
// Each width with each filter, with the largest window and again with any.
constexpr std::uint32_t kSeeds = 2 * 4 * kWidths.size();

/// A volume of one of these widths and random grey levels, and random options of the filter.
struct Case {
  explicit Case(std::uint32_t seed)
      : random(seed), frames(static_cast<std::uint32_t>(draw(1, 4))), volume(geometry(seed), frames) {
    for (std::uint32_t frame = 0; frame < frames; ++frame) {
      for (std::uint8_t& grey : volume.next_frame_pixels()) {
        // Edges, speckle, saturated pixels, and some that were not scanned.
        const int level = draw(0, 9) == 0 ? draw(0, 1) * 255 : draw(40, 60) + (draw(0, 3) == 0 ? 100 : 0);
        grey = static_cast<std::uint8_t>(draw(0, 7) == 0 ? 0 : level);
      }
      volume.add_frame({.angle_rad = 0.01 * frame});
    }
    volume.sort_by_angle();
    speckle.filter = static_cast<SpeckleFilter>(seed / kWidths.size() % 4);
    speckle.size = seed <= kSeeds / 2 ? 7 : 2 * draw(0, 3) + 1;
    speckle.across = 2 * draw(0, 1) + 1;
    speckle.noise = draw(0, 1) * 0.3;
    speckle.levels = draw(0, 20);
  }

  int draw(int least, int most) { return std::uniform_int_distribution(least, most)(random); }

  FanGeometry geometry(std::uint32_t seed) {
    return {.columns = kWidths[seed % kWidths.size()],
            .rows = static_cast<std::uint32_t>(draw(0, 4) == 0 ? draw(1, 5) : draw(6, 40)),
            .pixel_width_mm = 1,
            .pixel_height_mm = 1,
            .motor_radius_mm = 30,
            .zero_is_unscanned = draw(0, 1) == 1};
  }

  std::uint32_t columns() const { return volume.geometry().columns; }
  std::uint32_t rows() const { return volume.geometry().rows; }

  /// The frames as FrameStore stages them: rows of whole words of four pixels.
  std::vector<std::uint8_t> staged() const {
    const std::uint32_t row_bytes = (columns() + 3) / 4 * 4;
    std::vector<std::uint8_t> bytes(std::size_t{row_bytes} * rows() * frames);
    for (std::uint32_t frame = 0; frame < frames; ++frame) {
      const auto pixels = volume.frame_pixels(volume.by_angle()[frame]);
      for (std::uint32_t row = 0; row < rows(); ++row) {
        std::copy_n(pixels.begin() + std::size_t{row} * columns(), columns(),
                    bytes.begin() + (std::size_t{frame} * rows() + row) * row_bytes);
      }
    }
    return bytes;
  }

  std::vector<PreparedFrame> prepared() const {
    const auto bytes = staged();
    const StagedFrames all{.pixels = bytes.data(),
                           .columns = columns(),
                           .rows = rows(),
                           .row_bytes = (columns() + 3) / 4 * 4,
                           .frames = frames,
                           .zero_is_unscanned = volume.geometry().zero_is_unscanned};
    FramePreparer preparer(columns());
    std::vector<PreparedFrame> result;
    for (std::uint32_t frame = 0; frame < frames; ++frame) {
      // Exactly as much memory as a frame has, so that the address sanitizer sees a write beyond it.
      PreparedFrame& to = result.emplace_back();
      to.packed.resize(std::size_t{FANLIGHT_PACKED_STRIDE(columns())} * FANLIGHT_PACKED_ROWS(rows()));
      to.bounds.resize(std::size_t{blocks_along(columns())} * blocks_along(rows()));
      preparer.prepare(all, speckle, frame, {.packed = to.packed.data(), .bounds = to.bounds.data()});
      // What is behind the last column depends on the length of a vector.
      for (std::size_t word = 0; word < to.packed.size(); ++word) {
        if (word % FANLIGHT_PACKED_STRIDE(columns()) >= columns()) to.packed[word] = 0;
      }
    }
    return result;
  }

  /// A pixel of a packed frame, by the word in which `row` is the first of a sample's two rows.
  int grey(const PreparedFrame& frame, std::uint32_t column, std::uint32_t row) const {
    const std::size_t word = std::size_t{row / 3} * FANLIGHT_PACKED_STRIDE(columns()) + column;
    return static_cast<int>(frame.packed[word] >> (8 * (row % 3)) & 0xFF);
  }

  std::mt19937 random;
  std::uint32_t frames;
  Volume volume;
  Scene::Speckle speckle;
};

class FramePreparerTest : public testing::TestWithParam<std::uint32_t> {};

TEST_P(FramePreparerTest, FiltersAsTheTwinDoes) {
  const Case given(GetParam());
  const auto prepared = given.prepared();
  const Volume twin = twin_prepare(given.speckle, given.volume);
  int compared = 0;
  int apart = 0;
  for (std::uint32_t frame = 0; frame < given.frames; ++frame) {
    const auto expected = twin.frame_pixels(twin.by_angle()[frame]);
    for (std::uint32_t row = 0; row < given.rows(); ++row) {
      for (std::uint32_t column = 0; column < given.columns(); ++column) {
        const int wanted = expected[std::size_t{row} * given.columns() + column];
        const int got = given.grey(prepared[frame], column, row);
        ASSERT_LE(std::abs(got - wanted), given.speckle.filter == SpeckleFilter::kGuided ? 1 : 0)
            << "frame " << frame << ", row " << row << ", column " << column;
        apart += got != wanted ? 1 : 0;
        ++compared;
      }
    }
  }
  // The lines have 16 bits, and their results are rounded.
  EXPECT_LE(apart, 1 + compared / 50);
}

TEST_P(FramePreparerTest, RepeatsTheFirstRowOfTheNextWord) {
  const Case given(GetParam());
  for (const PreparedFrame& frame : given.prepared()) {
    for (std::uint32_t row = 0; row < given.rows(); ++row) {
      for (std::uint32_t column = 0; column < given.columns(); ++column) {
        const std::size_t word = std::size_t{row / 3} * FANLIGHT_PACKED_STRIDE(given.columns()) + column;
        const auto below = static_cast<int>(frame.packed[word] >> (8 * (row % 3 + 1)) & 0xFF);
        ASSERT_EQ(below, given.grey(frame, column, std::min(row + 1, given.rows() - 1)));
      }
    }
  }
}

TEST_P(FramePreparerTest, BoundsAllPixelsOfANeighbourhood) {
  const Case given(GetParam());
  constexpr std::uint32_t kSide = FANLIGHT_BLOCK * FANLIGHT_BLOCKS_IN_BOUND;
  for (const PreparedFrame& frame : given.prepared()) {
    for (std::uint32_t block = 0; block < frame.bounds.size(); ++block) {
      const std::uint32_t left = block % blocks_along(given.columns()) * FANLIGHT_BLOCK;
      const std::uint32_t top = block / blocks_along(given.columns()) * FANLIGHT_BLOCK;
      int least = 255;
      int greatest = 0;
      for (std::uint32_t row = top; row < std::min(top + kSide, given.rows()); ++row) {
        for (std::uint32_t column = left; column < std::min(left + kSide, given.columns()); ++column) {
          least = std::min(least, given.grey(frame, column, row));
          greatest = std::max(greatest, given.grey(frame, column, row));
        }
      }
      ASSERT_EQ(frame.bounds[block], static_cast<std::uint32_t>(least | greatest << 8)) << "block " << block;
    }
  }
}

TEST_P(FramePreparerTest, IsTheSameOnEveryInstructionSet) {
  const Case given(GetParam());
  const auto chosen = given.prepared();
  const auto supported = hwy::SupportedTargets();
  int compared = 0;
  for (auto rest = supported; rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    hwy::GetChosenTarget().DeInit();  // the next call chooses again
    EXPECT_EQ(given.prepared(), chosen) << hwy::TargetName(rest & -rest);
    ++compared;
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
  EXPECT_GE(compared, 2);  // the best one and one without vectors, of which Highway has one everywhere
}

INSTANTIATE_TEST_SUITE_P(Seeds, FramePreparerTest, testing::Range(1U, kSeeds + 1));

}  // namespace
}  // namespace fanlight::test::frame_preparer_tests
