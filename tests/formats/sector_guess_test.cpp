// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/sector_guess.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "acquisition/phantom/phantom_source.hpp"
#include "acquisition/replay/recording_file.hpp"
#include "acquisition/replay/seen_sector.hpp"
#include "proto/model/fan_geometry.hpp"
#include "tests/support/data_folder.hpp"

namespace fanlight::test {
namespace {

/// Every pixel's greatest grey level in all frames.
std::vector<std::uint8_t> brightest_of(const FrameSequence& sequence) {
  std::vector<std::uint8_t> brightest(sequence.frame_bytes());
  for (std::size_t frame = 0; frame < sequence.frames.size(); ++frame) {
    const auto pixels = sequence.frame_pixels(frame);
    for (std::size_t i = 0; i < brightest.size(); ++i) brightest[i] = std::max(brightest[i], pixels[i]);
  }
  return brightest;
}

std::optional<SectorGuess> guess_of(const char* file) {
  const auto sequence = read_recording_file(data_folder() / file, std::uint64_t{1} << 30);
  if (!sequence) return std::nullopt;
  return guess_sector(brightest_of(*sequence), sequence->columns, sequence->rows, 1);
}

TEST(SectorGuessTest, FindsTheSectorOfTheLiver) {
  if (!std::filesystem::exists(data_folder() / "liver_fan_sweep.igs.mha"))
    GTEST_SKIP() << "no real recordings";
  const auto guess = guess_of("liver_fan_sweep.igs.mha");
  ASSERT_TRUE(guess);
  EXPECT_TRUE(guess->diverges);
  EXPECT_NEAR(guess->face_column, 369, 2);
  EXPECT_NEAR(guess->face_row, 22, 3);
  EXPECT_NEAR(guess->apex_row, -139.3, 3);
  EXPECT_NEAR(guess->half_angle_deg, 30.28, 0.5);
  EXPECT_NEAR((guess->last_row - guess->apex_row) * 0.3148178, 228.04, 3);
}

TEST(SectorGuessTest, FindsASectorOf150Degrees) {
  const char* const file = "UltrasonixCurvilinearScanConvertedData.igs.mha";
  if (!std::filesystem::exists(data_folder() / file)) GTEST_SKIP() << "no real recordings";
  const auto guess = guess_of(file);
  ASSERT_TRUE(guess);
  EXPECT_TRUE(guess->diverges);
  EXPECT_NEAR(guess->face_column, 409.5, 3);
  EXPECT_NEAR(guess->face_row, 87, 4);
  EXPECT_NEAR(guess->apex_row, 87 - 10 / 0.15, 4);
  EXPECT_NEAR(guess->half_angle_deg, 75, 1.5);
}

std::vector<std::uint8_t> drawn(std::uint32_t columns, std::uint32_t rows, auto&& inside) {
  std::vector<std::uint8_t> pixels(std::size_t{columns} * rows);
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column)
      pixels[row * columns + column] = inside(column, row) ? 200 : 3;
  }
  return pixels;
}

TEST(SectorGuessTest, CountsPixelsThatAreNoSquares) {
  // 0.5 mm wide, 0.25 mm high; apex at (150, -40), 30 deg to either side, from 30 to 90 mm.
  const auto pixels = drawn(300, 400, [](double column, double row) {
    const double x_mm = (column - 150) * 0.5;
    const double y_mm = (row + 40) * 0.25;
    const double mm = std::hypot(x_mm, y_mm);
    return std::abs(std::atan2(x_mm, y_mm)) < radians(30) && mm > 30 && mm < 90;
  });
  const auto guess = guess_sector(pixels, 300, 400, 2);
  ASSERT_TRUE(guess);
  EXPECT_NEAR(guess->half_angle_deg, 30, 0.3);
  EXPECT_NEAR(guess->apex_row, -40, 2);
  EXPECT_NEAR(guess->face_row, 80, 1.5);
  EXPECT_NEAR(guess->last_row, 320, 1.5);
}

TEST(SectorGuessTest, FindsARectangleAndIgnoresLetters) {
  const auto pixels = drawn(200, 300, [](std::uint32_t column, std::uint32_t row) {
    const bool letters = row < 12 && column % 5 < 3;
    const bool scale = row % 20 < 2 && column > 190 && column < 195;
    return letters || scale || (column >= 40 && column < 160 && row >= 20 && row < 280);
  });
  const auto guess = guess_sector(pixels, 200, 300, 1);
  ASSERT_TRUE(guess);
  EXPECT_FALSE(guess->diverges);
  EXPECT_NEAR(guess->left_column, 40, 1);
  EXPECT_NEAR(guess->right_column, 159, 1);
  EXPECT_NEAR(guess->face_row, 20, 1);
  EXPECT_NEAR(guess->last_row, 279, 1);
}

TEST(SectorGuessTest, FindsNothingWhereNothingIs) {
  EXPECT_FALSE(guess_sector(std::vector<std::uint8_t>(100 * 100), 100, 100, 1));
  EXPECT_FALSE(guess_sector(std::vector<std::uint8_t>(100 * 100, 255), 100, 100, 1)) << "no border is seen";
  EXPECT_FALSE(guess_sector(std::vector<std::uint8_t>(4, 255), 2, 2, 1));
  std::minstd_rand random(1);
  std::vector<std::uint8_t> noise(100 * 100);
  for (auto& pixel : noise) pixel = static_cast<std::uint8_t>(random() >> 8);
  EXPECT_FALSE(guess_sector(noise, 100, 100, 1));
}

TEST(StepGuessTest, MeasuresTheStepBySpeckle) {
  // Speckle that is equally wide in every direction, moved by 3 columns from frame to frame.
  constexpr std::uint32_t kColumns = 300;
  constexpr std::uint32_t kRows = 200;
  std::minstd_rand random(7);
  std::vector<double> noise(kRows * (kColumns + 40));
  for (double& value : noise) value = static_cast<double>(random() % 1000) / 1000;
  const auto frame = [&](std::uint32_t shift) {
    std::vector<std::uint8_t> pixels(kRows * kColumns);
    for (std::uint32_t row = 0; row < kRows; ++row) {
      for (std::uint32_t column = 0; column < kColumns; ++column) {
        double sum = 0;
        for (int k = -8; k <= 8; ++k)
          sum += noise[row * (kColumns + 40) + column + shift + static_cast<std::uint32_t>(k + 10)] *
                 std::exp(-k * k / 18.0);
        pixels[row * kColumns + column] = static_cast<std::uint8_t>(std::clamp(20 * sum, 0.0, 255.0));
      }
    }
    return pixels;
  };
  SectorGuess sector;
  sector.face_column = kColumns / 2.0;
  sector.last_row = kRows;
  StepGuesser guesser(kColumns, kRows, sector);
  guesser.add(frame(0), frame(3));
  guesser.add(frame(3), frame(6));
  const auto step = guesser.guess();
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->step_columns, 3, 0.3);
  StepGuesser still(kColumns, kRows, sector);
  still.add(frame(0), frame(0));
  EXPECT_FALSE(still.guess()) << "a frame that does not move";
}

/// Only where the geometry agrees with what is seen.
TEST(SeenSectorTest, CompletesAGeometryThatItFits) {
  const FanGeometry geometry{.columns = 300,
                             .rows = 400,
                             .pixel_width_mm = 0.5,
                             .pixel_height_mm = 0.25,
                             .face_column = 150,
                             .face_row = 80,
                             .motor_radius_mm = 30};
  const SectorGuess seen{.diverges = true,
                         .face_column = 151,
                         .face_row = 82,
                         .last_row = 320,
                         .apex_row = -40,
                         .half_angle_deg = 30};
  const auto found = with_sector(geometry, seen);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->sector.half_angle_deg, 30);
  EXPECT_EQ(found->probe_radius_mm, 30);
  EXPECT_EQ(found->sector.reach_mm, 0) << "deeper echoes may come";

  const auto misfits = [&](auto&& change) {
    FanGeometry of = geometry;
    SectorGuess by = seen;
    change(of, by);
    return !with_sector(of, by);
  };
  EXPECT_TRUE(misfits([](FanGeometry& of, SectorGuess&) { of.face_column = 160; }));
  EXPECT_TRUE(misfits([](FanGeometry& of, SectorGuess&) { of.face_row = 60; }));
  EXPECT_TRUE(misfits([](FanGeometry& of, SectorGuess&) { of.probe_radius_mm = 60; }));
  EXPECT_TRUE(misfits([](FanGeometry&, SectorGuess& by) { by.diverges = false; }));
  EXPECT_TRUE(misfits([](FanGeometry&, SectorGuess& by) { by.half_angle_deg = 3; }));
  EXPECT_TRUE(misfits([](FanGeometry&, SectorGuess& by) { by.lean_deg = -8; })) << "a side without contact";
}

}  // namespace
}  // namespace fanlight::test
