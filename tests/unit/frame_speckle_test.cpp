// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/frame_speckle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace fanlight::test {
namespace {

constexpr std::uint32_t kRows = 512;  // of the tile, where its rows wrap
constexpr std::uint32_t kColumns = SpeckleTile::kSide;

/// The factors of a frame, rows x columns.
std::vector<double> frame(FrameSpeckle& speckle, const FrameSpeckle::Place& place) {
  speckle.set_place(place);
  std::vector<double> factors;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (const std::uint8_t factor : speckle.row(row))
      factors.push_back(double{1} * factor / FrameSpeckle::kOne);
  }
  return factors;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Of two frames, the second displaced.
double correlation(const std::vector<double>& one, const std::vector<double>& other, std::uint32_t down = 0,
                   std::uint32_t across = 0) {
  const double one_mean = mean_of(one);
  const double other_mean = mean_of(other);
  double product = 0;
  double squares = 0;
  double other_squares = 0;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const double here = one[row * kColumns + column] - one_mean;
      const double there = other[(row + down) % kRows * kColumns + (column + across) % kColumns] - other_mean;
      product += here * there;
      squares += here * here;
      other_squares += there * there;
    }
  }
  return product / std::sqrt(squares * other_squares);
}

FrameSpeckle speckle_of(float deviation) {
  return {1, kColumns, std::vector<float>(kRows, deviation)};
}

// Fully developed speckle: mean over standard deviation of a Rayleigh distribution is 1.91. Its correlation
// falls to one half at 1 pixel along the beam and 1.5 across it: a speckle is 2 by 3 pixels.
TEST(FrameSpeckleTest, IsRayleighAndCorrelatedInAFrame) {
  for (const float deviation : {0.0F, 1.0F}) {
    FrameSpeckle speckle = speckle_of(deviation);
    const std::vector<double> factors = frame(speckle, {.sweep = 0, .frame = 3});
    const double mean = mean_of(factors);
    double squares = 0;
    for (const double factor : factors) squares += (factor - mean) * (factor - mean);
    EXPECT_NEAR(mean, 1, 0.02) << deviation;
    EXPECT_NEAR(mean / std::sqrt(squares / static_cast<double>(factors.size())), 1.91, 0.05) << deviation;
    EXPECT_NEAR(correlation(factors, factors, 1, 0), 0.5, 0.05) << deviation;
    EXPECT_GT(correlation(factors, factors, 0, 1), 0.6) << deviation;
    EXPECT_LT(correlation(factors, factors, 0, 2), 0.4) << deviation;
    EXPECT_LT(correlation(factors, factors, 4, 0), 0.05) << deviation;
    EXPECT_LT(correlation(factors, factors, 0, 6), 0.05) << deviation;
  }
}

// The field of a Gaussian beam is correlated by exp(-d^2 / (8 s^2)) between frames d apart, where s is the
// standard deviation of its power; the magnitude by nearly the square of that.
TEST(FrameSpeckleTest, IsCorrelatedBetweenFramesWithinTheBeam) {
  constexpr float kDeviation = 1;
  FrameSpeckle speckle = speckle_of(kDeviation);
  const std::vector<double> first = frame(speckle, {.sweep = 4, .frame = 10});
  for (const double away : {0.5, 1.0, 2.0, 3.0}) {
    const double field = std::exp(-away * away / (8 * kDeviation * kDeviation));
    const std::vector<double> other = frame(speckle, {.sweep = 4, .frame = 10 + away});
    EXPECT_NEAR(correlation(first, other), field * field, 0.07) << away;
  }
}

TEST(FrameSpeckleTest, IsNewInEachFrameOfAThinBeamAndInEachSweep) {
  FrameSpeckle thin = speckle_of(0.1F);
  EXPECT_NEAR(correlation(frame(thin, {.sweep = 0, .frame = 0}), frame(thin, {.sweep = 0, .frame = 1})), 0,
              0.03);
  FrameSpeckle thick = speckle_of(1);
  EXPECT_NEAR(correlation(frame(thick, {.sweep = 0, .frame = 5}), frame(thick, {.sweep = 1, .frame = 5})), 0,
              0.03);
}

TEST(FrameSpeckleTest, EqualSeedsGiveEqualFrames) {
  FrameSpeckle one = speckle_of(1);
  FrameSpeckle other = speckle_of(1);
  EXPECT_EQ(frame(one, {.sweep = 2, .frame = 7.25}), frame(other, {.sweep = 2, .frame = 7.25}));
}

TEST(FrameSpeckleTest, RepeatsTheTileAcrossMoreColumnsThanItHas) {
  FrameSpeckle speckle(1, kColumns + 100, std::vector<float>(1, 1.0F));
  speckle.set_place({.sweep = 0, .frame = 2});
  const auto factors = speckle.row(0);
  for (std::uint32_t column = 0; column < 100; ++column)
    EXPECT_EQ(factors[column], factors[kColumns + column]);
}

}  // namespace
}  // namespace fanlight::test
