// SPDX-License-Identifier: Apache-2.0
// Options of the simulated probe, and the motor faults that some of them produce.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "acquisition/phantom/phantom_options.hpp"
#include "tests/unit/phantom_frames.hpp"

namespace fanlight::test {
namespace {

TEST(PhantomMotor, ItsMeasuredAnglesCanLagByDirection) {
  auto config = kSpeckled;
  config.lag_deg = 1;
  const auto lagging = make(config);
  const auto exact = make(kSpeckled);
  ASSERT_NE(lagging, nullptr);
  EXPECT_NEAR(degrees(lagging->description().last_angle_rad), 35.5, 1e-9);
  for (int i = 0; i < 3 * 35; ++i) {
    const FrameStamp measured = next_stamp(*lagging);
    const FrameStamp truth = next_stamp(*exact);
    const double half_deg = truth.direction == SweepDirection::kForward ? -0.5 : 0.5;
    EXPECT_NEAR(degrees(measured.angle_rad - truth.angle_rad), half_deg, 1e-9);
    if (i % 50 != 3) continue;
    std::vector<std::uint8_t> pixels(exact->description().geometry.frame_bytes());
    std::vector<std::uint8_t> expected(pixels.size());
    lagging->read_pixels(pixels, {});
    exact->read_pixels(expected, {});
    EXPECT_EQ(pixels, expected) << "the frame shows the true place";
  }
}

TEST(PhantomMotor, ItsMeasuredAnglesCanJitter) {
  auto config = kSpeckled;
  config.jitter_deg = 0.5;
  const auto jittering = make(config);
  const auto exact = make(kSpeckled);
  ASSERT_NE(jittering, nullptr);
  double sum_deg = 0;
  double largest_deg = 0;
  for (int i = 0; i < 1000; ++i) {
    const double off_deg = degrees(next_stamp(*jittering).angle_rad - next_stamp(*exact).angle_rad);
    sum_deg += off_deg;
    largest_deg = std::max(largest_deg, std::abs(off_deg));
  }
  EXPECT_NEAR(sum_deg / 1000, 0, 0.03);
  EXPECT_LE(largest_deg, 0.5);
  EXPECT_GT(largest_deg, 0.49);
}

TEST(PhantomMotor, ItCanTurnEarlyAndLate) {
  auto config = kSpeckled;
  config.turning_frames = 3;
  const auto source = make(config);
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->description().frames_per_volume, 41U);
  std::set<std::uint32_t> lengths;
  FrameStamp last = next_stamp(*source);
  for (int i = 0; i < 3500; ++i) {
    const FrameStamp stamp = next_stamp(*source);
    EXPECT_EQ(stamp.frames_in_sweep, 0U);
    EXPECT_LE(std::abs(stamp.angle_rad), source->description().last_angle_rad + 1e-9);
    if (stamp.volume_index != last.volume_index) {
      lengths.insert(last.frame_index + 1);
      EXPECT_NEAR(stamp.angle_rad, last.angle_rad, 1e-9);
      EXPECT_NE(stamp.direction, last.direction);
    } else {
      EXPECT_NEAR(degrees(std::abs(stamp.angle_rad - last.angle_rad)), 70.0 / 34, 1e-9);
    }
    last = stamp;
  }
  EXPECT_GE(*lengths.begin(), 29U);
  EXPECT_LE(*lengths.rbegin(), 41U);
  EXPECT_GT(lengths.size(), 8U);
}

TEST(PhantomMotor, ItNeedNotNameItsVolumes) {
  auto config = kSpeckled;
  config.index = PhantomSource::Index::kOff;
  const auto source = make(config);
  ASSERT_NE(source, nullptr);
  EXPECT_FALSE(source->description().counts_volumes);
  EXPECT_GT(source->description().frames_per_volume, 35U) << "room for frames beyond the turn";
  for (int i = 0; i < 80; ++i) {
    const FrameStamp stamp = next_stamp(*source);
    EXPECT_EQ(stamp.volume_index, 0U);
    EXPECT_EQ(stamp.frame_index, 0U);
    EXPECT_EQ(stamp.frames_in_sweep, 0U);
    EXPECT_EQ(stamp.direction, SweepDirection::kForward);
  }
}

TEST(PhantomMotor, ItCanLoseFrames) {
  auto config = kSpeckled;
  config.lost_percent = 10;
  const auto source = make(config);
  const auto whole = make(kSpeckled);
  ASSERT_NE(source, nullptr);
  std::uint64_t sequence = 0;
  for (int i = 0; i < 2000; ++i) {
    const FrameStamp stamp = next_stamp(*source);
    FrameStamp same = next_stamp(*whole);
    while (same.sequence < stamp.sequence) same = next_stamp(*whole);
    EXPECT_EQ(stamp.angle_rad, same.angle_rad);
    EXPECT_EQ(stamp.volume_index, same.volume_index);
    sequence = stamp.sequence;
  }
  EXPECT_NEAR(static_cast<double>(sequence), 2000 / 0.9, 50);
}

TEST(PhantomOptions, AreRead) {
  const auto config = parse_phantom(
      "rate=20,frames=9,columns=64,rows=32,sweep=60.5,seed=7,speckle=off,moving=off,volumes=3,beam=2.5,"
      "scan=convex,lag=-1.5,jitter=0.25,turning=3,index=off,lost=2.5",
      {});
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->frame_rate_hz, 20);
  EXPECT_EQ(config->frames_per_volume, 9U);
  EXPECT_EQ(config->columns, 64U);
  EXPECT_EQ(config->rows, 32U);
  EXPECT_EQ(config->sweep_deg, 60.5);
  EXPECT_EQ(config->seed, 7U);
  EXPECT_EQ(config->volumes, 3U);
  EXPECT_EQ(config->beam_mm, 2.5);
  EXPECT_EQ(config->scan, FrameKind::kConvexLines);
  EXPECT_EQ(config->speckle, PhantomSource::Speckle::kOff);
  EXPECT_EQ(config->motion, PhantomScene::Motion::kStill);
  EXPECT_EQ(config->lag_deg, -1.5);
  EXPECT_EQ(config->jitter_deg, 0.25);
  EXPECT_EQ(config->turning_frames, 3U);
  EXPECT_EQ(config->index, PhantomSource::Index::kOff);
  EXPECT_EQ(config->lost_percent, 2.5);
  EXPECT_TRUE(parse_phantom("", {}));
  EXPECT_EQ(parse_phantom("scan=cartesian", {})->scan, FrameKind::kCartesian);
  EXPECT_EQ(parse_phantom("scan=linear", {})->scan, FrameKind::kLinearLines);
  EXPECT_EQ(parse_phantom("speckle=on", {.speckle = PhantomSource::Speckle::kOff})->speckle,
            PhantomSource::Speckle::kOn);
}

TEST(PhantomOptions, AProbeSetsWhatComesBeforeIt) {
  const auto r2 = parse_phantom("frames=9,beam=4,probe=r2,columns=100,scene=face", {});
  ASSERT_TRUE(r2) << r2.error().message;
  EXPECT_EQ(r2->frames_per_volume, 60U);
  EXPECT_EQ(r2->beam_mm, 2.5);
  EXPECT_EQ(r2->columns, 100U) << "what comes after it holds";
  EXPECT_EQ(r2->scan, FrameKind::kConvexLines);
  EXPECT_EQ(r2->probe_radius_mm, 40);
  EXPECT_EQ(r2->scene, PhantomSource::Scene::kFace);
  const auto r1 = parse_phantom("probe=r2,probe=r1", {});
  ASSERT_TRUE(r1);
  EXPECT_EQ(r1->frames_per_volume, PhantomSource::Config{}.frames_per_volume);
  EXPECT_EQ(r1->probe_radius_mm, PhantomSource::Config{}.probe_radius_mm);
  EXPECT_FALSE(parse_phantom("scene=mesh", {}));
  EXPECT_FALSE(parse_phantom("probe=r3", {}));
}

TEST(PhantomOptions, AreRefusedInOneSentence) {
  const auto refusal = [](std::string_view text) {
    const auto config = parse_phantom(text, {});
    return config ? std::string("taken") : config.error().message;
  };
  EXPECT_EQ(refusal("colums=2"), "the phantom has no option \"colums\", did you mean columns?");
  EXPECT_EQ(
      refusal("film=2"),
      "the phantom has no option \"film\", expected rate, frames, columns, rows, sweep, seed, "
      "volumes, beam, speckle, clutter, moving, probe, scene, wall, scan, compression, range, gain, lag, "
      "jitter, turning, "
      "index, lost");
  EXPECT_EQ(refusal("rate=fast"), "the phantom's rate is \"fast\", expected 0.1 to 1000 frames a second");
  EXPECT_EQ(refusal("rate=0"), "the phantom's rate is 0, expected 0.1 to 1000 frames a second");
  EXPECT_EQ(refusal("rate=nan"), "the phantom's rate is \"nan\", expected 0.1 to 1000 frames a second");
  EXPECT_EQ(refusal("frames=1"), "the phantom's frames is 1, expected 2 to 1024 a volume");
  EXPECT_EQ(refusal("frames=-5"), "the phantom's frames is \"-5\", expected 2 to 1024 a volume");
  EXPECT_EQ(refusal("sweep=180"), "the phantom's sweep is 180, expected 1 to 170 deg");
  EXPECT_EQ(refusal("speckle=maybe"), "the phantom's speckle is \"maybe\", expected on or off");
  EXPECT_EQ(refusal("scan=polar"), "the phantom's scan is \"polar\", expected cartesian, convex or linear");
  EXPECT_EQ(refusal("moving"), "the phantom's moving is \"\", expected on or off");
  EXPECT_EQ(refusal("lag=5"), "the phantom's lag is 5, expected -4 to 4 deg");
  EXPECT_EQ(refusal("jitter=-1"), "the phantom's jitter is -1, expected 0 to 2 deg");
  EXPECT_EQ(refusal("turning=some"), "the phantom's turning is \"some\", expected 0 to 16 frames");
  EXPECT_EQ(refusal("turning=17"), "the phantom's turning is 17, expected 0 to 16 frames here");
  EXPECT_EQ(refusal("frames=6,turning=3"), "the phantom's turning is 3, expected 0 to 2 frames here");
  EXPECT_EQ(refusal("sweep=168,turning=1"), "the phantom's turning is 1, expected 0 to 0 frames here");
  EXPECT_EQ(refusal("index=maybe"), "the phantom's index is \"maybe\", expected on or off");
  EXPECT_EQ(refusal("lost=51"), "the phantom's lost is 51, expected 0 to 50 percent");
  EXPECT_NE(refusal("rate=20,,frames=4"), "taken");
  EXPECT_NE(refusal("rate=20 "), "taken");
}

}  // namespace
}  // namespace fanlight::test
