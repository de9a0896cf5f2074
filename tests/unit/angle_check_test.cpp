// SPDX-License-Identifier: Apache-2.0
#include "acquisition/source/angle_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "proto/model/fan_geometry.hpp"

namespace fanlight::test {
namespace {

using Frames = std::vector<AngleCheck::Frame>;
using Indices = std::vector<std::size_t>;

/// A sweep of 74 frames, 1 deg apart.
Frames even_sweep(std::size_t frames = 74) {
  Frames sweep;
  for (std::size_t i = 0; i < frames; ++i) {
    sweep.push_back({.sequence = 100 + i, .angle_rad = radians(static_cast<double>(i) - 37)});
  }
  return sweep;
}

struct Found {
  Indices outliers;
  double usual_step_deg;
  double gap_deg;
};

Found check(const Frames& frames) {
  AngleCheck angle_check(frames.size());
  const auto findings = angle_check.check(frames);
  return {{findings.outliers.begin(), findings.outliers.end()},
          degrees(findings.usual_step_rad),
          degrees(findings.gap_rad)};
}

TEST(AngleCheckTest, FindsNothingInAnEvenSweepEitherWay) {
  Frames sweep = even_sweep();
  EXPECT_EQ(check(sweep).outliers, Indices());
  EXPECT_NEAR(check(sweep).usual_step_deg, 1, 1e-9);
  EXPECT_EQ(check(sweep).gap_deg, 0);
  for (AngleCheck::Frame& frame : sweep) frame.angle_rad = -frame.angle_rad;
  EXPECT_EQ(check(sweep).outliers, Indices());
}

TEST(AngleCheckTest, FindsOneWrongAngleWhereverItIs) {
  for (const std::size_t wrong : {0U, 1U, 20U, 72U, 73U}) {
    Frames sweep = even_sweep();
    sweep[wrong].angle_rad = radians(60);
    EXPECT_EQ(check(sweep).outliers, (wrong == 73U ? Indices{73} : Indices{wrong})) << wrong;
    EXPECT_EQ(check(sweep).gap_deg, 0) << wrong;
  }
}

TEST(AngleCheckTest, FindsUpToThreeWrongAnglesInARow) {
  Frames sweep = even_sweep();
  for (const std::size_t wrong : {30U, 31U, 32U}) sweep[wrong].angle_rad = radians(-80);
  EXPECT_EQ(check(sweep).outliers, (Indices{30, 31, 32}));
  sweep[33].angle_rad = radians(-80);
  EXPECT_GT(check(sweep).gap_deg, 70) << "four are a part of the sweep";
}

TEST(AngleCheckTest, FindsWrongAnglesThatLieApart) {
  Frames sweep = even_sweep();
  sweep[5].angle_rad = radians(80);
  sweep[50].angle_rad = radians(-80);
  sweep[52].angle_rad = radians(10);
  EXPECT_EQ(check(sweep).outliers, (Indices{5, 50, 52}));
}

TEST(AngleCheckTest, FindsAGapThatNoSequenceNumberTells) {
  Frames sweep = even_sweep();
  sweep.erase(sweep.begin() + 22, sweep.begin() + 52);
  for (std::size_t i = 0; i < sweep.size(); ++i) sweep[i].sequence = i;
  const Found found = check(sweep);
  EXPECT_EQ(found.outliers, Indices());
  EXPECT_NEAR(found.gap_deg, 31, 1e-6);
}

TEST(AngleCheckTest, TakesLostFramesForWhatTheyAre) {
  Frames sweep = even_sweep();
  sweep.erase(sweep.begin() + 22, sweep.begin() + 25);
  EXPECT_EQ(check(sweep).gap_deg, 0);
}

TEST(AngleCheckTest, AllowsAMotorWhoseSpeedIsASine) {
  Frames sweep;
  for (std::size_t i = 0; i < 60; ++i) {
    sweep.push_back({.sequence = i, .angle_rad = -0.6 * std::cos(kPi * static_cast<double>(i) / 59)});
  }
  EXPECT_EQ(check(sweep).outliers, Indices());
  EXPECT_EQ(check(sweep).gap_deg, 0);
}

TEST(AngleCheckTest, AllowsAnUnsteadyHand) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> step_deg(0.05, 0.7);
  Frames sweep;
  double angle_deg = -20;
  for (std::size_t i = 0; i < 140; ++i) {
    if (i % 17 != 0) angle_deg += step_deg(random);
    if (i % 50 == 49) angle_deg -= 0.15;
    sweep.push_back({.sequence = i, .angle_rad = radians(angle_deg)});
  }
  EXPECT_EQ(check(sweep).outliers, Indices());
  EXPECT_EQ(check(sweep).gap_deg, 0);
}

TEST(AngleCheckTest, AHandThatRestsAndMovesIsNoGap) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise_deg(-0.03, 0.03);
  Frames sweep;
  for (std::size_t i = 0; i < 120; ++i) {
    const double angle_deg = i < 40 ? -20 : i < 80 ? static_cast<double>(i) - 60 : 20;
    sweep.push_back({.sequence = i, .angle_rad = radians(angle_deg + noise_deg(random))});
  }
  EXPECT_EQ(check(sweep).outliers, Indices());
  EXPECT_EQ(check(sweep).gap_deg, 0);
}

TEST(AngleCheckTest, ThreeFramesLostWithoutANumberAreNoGap) {
  Frames sweep = even_sweep();
  sweep.erase(sweep.begin() + 30, sweep.begin() + 33);
  for (std::size_t i = 0; i < sweep.size(); ++i) sweep[i].sequence = i;
  EXPECT_EQ(check(sweep).gap_deg, 0);
  EXPECT_EQ(check(sweep).outliers, Indices());
}

TEST(AngleCheckTest, AllowsACoarseEncoder) {
  Frames sweep = even_sweep();
  for (AngleCheck::Frame& frame : sweep)
    frame.angle_rad = radians(4 * std::floor(degrees(frame.angle_rad) / 4));
  EXPECT_EQ(check(sweep).outliers, Indices());
  EXPECT_EQ(check(sweep).gap_deg, 0);
}

TEST(AngleCheckTest, JudgesNeitherAStandStillNorAFewFrames) {
  Frames still = even_sweep();
  for (AngleCheck::Frame& frame : still) frame.angle_rad = 0.1;
  EXPECT_EQ(check(still).outliers, Indices());
  Frames few = even_sweep(5);
  few[2].angle_rad = 1;
  EXPECT_EQ(check(few).outliers, Indices());
}

}  // namespace
}  // namespace fanlight::test
