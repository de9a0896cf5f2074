// SPDX-License-Identifier: Apache-2.0
// Residual of a known mismatch of forward and backward sweeps. Prints the results.
#include "acquisition/assembly/sweep_hysteresis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "acquisition/assembly/assembler.hpp"
#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"

namespace fanlight {
namespace {

constexpr double kAllowedDeg = 0.1;
// The reported value is from the last few volumes only, with their speckle and jitter.
constexpr double kReportDeg = 0.15;

/// Runs the simulated probe through an assembler, sweep by sweep.
class Rig {
 public:
  explicit Rig(const std::string& options, MismatchCorrection correction = MismatchCorrection::kOn)
      : config_(parse_phantom(options, {.pace = PhantomSource::Pace::kUnpaced}).value()),
        source_(PhantomSource::create(config_).value()),
        ring_({.geometry = source_->description().geometry,
               .frame_capacity = source_->description().frames_per_volume},
              {.reader_bell = bell_, .writer_bell = bell_}),
        assembler_(
            {.ring = ring_, .writer_bell = bell_, .counters = counters_},
            {.cut = config_.index == PhantomSource::Index::kOn ? SweepCut::kByIndex : SweepCut::kByTurning,
             .range = {source_->description().first_angle_rad, source_->description().last_angle_rad},
             .correction = correction}) {}

  /// The next volume; valid until the next call.
  const Volume& next() {
    lease_ = {};
    while (!ring_.has_published()) {
      const auto frame = source_->next_frame({}).value();
      const auto pixels = assembler_.place(*frame, source_->description().geometry, {});
      if (pixels.empty()) continue;
      source_->read_pixels(pixels, {});
      assembler_.commit();
    }
    lease_ = ring_.take();
    return *lease_;
  }

  /// True mismatch of forward and backward in a volume like this one, as published.
  double truly_left_deg(const Volume& volume) const {
    const double correction_deg = 2 * degrees(volume.stamp().angle_correction_rad);
    const bool forward = volume.stamp().direction == SweepDirection::kForward;
    return config_.lag_deg - (forward ? correction_deg : -correction_deg);
  }

  const AcquisitionCounters& counters() const { return counters_; }
  const FanGeometry& geometry() const { return source_->description().geometry; }

 private:
  PhantomSource::Config config_;
  std::unique_ptr<PhantomSource> source_;
  Doorbell bell_;
  AcquisitionCounters counters_;
  VolumeRing ring_;
  Assembler assembler_;
  VolumeRing::Lease lease_;
};

struct Case {
  const char* name;
  const char* options;
};

class Mismatch : public testing::TestWithParam<Case> {};

// Requirement, from the tenth volume on, against the truth.
TEST_P(Mismatch, IsTakenOut) {
  Rig rig(GetParam().options);
  double worst_deg = 0;
  double worst_report_deg = 0;
  for (int volume = 1; volume <= 16; ++volume) {
    const double left_deg = rig.truly_left_deg(rig.next());
    if (volume < 10) continue;
    worst_deg = std::max(worst_deg, std::abs(left_deg));
    worst_report_deg =
        std::max(worst_report_deg, std::abs(rig.counters().mismatch_left_deg.value() - left_deg));
    EXPECT_LE(std::abs(rig.counters().mismatch_left_deg.value()), kAllowedDeg) << "as reported";
  }
  EXPECT_LE(worst_deg, kAllowedDeg);
  EXPECT_LE(worst_report_deg, kReportDeg);
  EXPECT_EQ(rig.counters().mismatch_estimates.value(), 14U);
  EXPECT_EQ(rig.counters().mismatch_refusals.value(), 0U);
  const FanGeometry& geometry = rig.geometry();
  const double radius_mm = geometry.motor_radius_mm + geometry.depth_mm() / 2;
  EXPECT_NEAR(1000 * rig.counters().mismatch_left_m.value(),
              radius_mm * radians(rig.counters().mismatch_left_deg.value()), 1e-9);
  RecordProperty("worst_left_deg", std::to_string(worst_deg));
  std::printf("%-34s left after 10 volumes, at worst: %.3f deg (%.2f mm); reported %.3f deg\n",
              GetParam().name, worst_deg, radius_mm * radians(worst_deg),
              rig.counters().mismatch_left_deg.value());
}

INSTANTIATE_TEST_SUITE_P(
    Injected, Mismatch,
    testing::Values(Case{"Still_1_0", "lag=1,moving=off,columns=192,rows=192"},
                    Case{"Moving_1_0", "lag=1,columns=192,rows=192"},
                    Case{"Moving_minus_1_0", "lag=-1,columns=192,rows=192,seed=2"},
                    Case{"Moving_0_0", "lag=0,columns=192,rows=192,seed=3"},
                    Case{"Moving_2_5", "lag=2.5,columns=192,rows=192,seed=4"},
                    Case{"Moving_1_0_Without_Speckle", "lag=1,speckle=off,columns=192,rows=192"},
                    Case{"Moving_1_0_Convex", "lag=1,scan=convex,columns=192,rows=192,seed=5"},
                    Case{"Moving_1_0_Linear", "lag=1,scan=linear,columns=192,rows=192,seed=6"},
                    Case{"Moving_1_0_70_Frames", "lag=1,frames=70,columns=192,rows=192,seed=7"},
                    Case{"Moving_1_0_Twice_As_Fast", "lag=1,rate=150,columns=192,rows=192,seed=8"},
                    Case{"Moving_1_0_Jitter_0_2", "lag=1,jitter=0.2,columns=192,rows=192,seed=9"},
                    Case{"Moving_1_0_Turning_2", "lag=1,turning=2,columns=192,rows=192,seed=10"},
                    Case{"Moving_1_0_By_Turning", "lag=1,index=off,columns=192,rows=192,seed=11"},
                    Case{"Moving_1_0_Lost_2_Percent", "lag=1,lost=2,columns=192,rows=192,seed=12"}),
    [](const testing::TestParamInfo<Case>& each) { return std::string(each.param.name); });

// Size of R1.
INSTANTIATE_TEST_SUITE_P(Of512, Mismatch, testing::Values(Case{"Moving_1_0", "lag=1"}),
                         [](const testing::TestParamInfo<Case>& each) {
                           return std::string(each.param.name);
                         });

// Sweeps of almost two seconds with the largest motion of the face: a mismatch that cannot be identified must
// stay uncorrected.
class SlowMismatch : public testing::TestWithParam<Case> {};

TEST_P(SlowMismatch, DoesLittleHarm) {
  Rig rig(GetParam().options);
  const double injected_deg = rig.truly_left_deg(rig.next());
  double worst_deg = 0;
  double last_deg = 0;
  for (int volume = 2; volume <= 40; ++volume) {
    last_deg = rig.truly_left_deg(rig.next());
    if (volume >= 10) worst_deg = std::max(worst_deg, std::abs(last_deg));
  }
  std::printf("%-34s of %.1f deg left: at worst %.3f deg from volume 10 on, %.3f after 40\n", GetParam().name,
              injected_deg, worst_deg, last_deg);
  EXPECT_LE(worst_deg, std::max(0.25, std::abs(injected_deg)));
  // Of 1 deg 0.28 to 0.31 are left with ten seeds: in almost two seconds the face moves between the sweeps.
  EXPECT_LE(std::abs(last_deg), 0.35);
}

INSTANTIATE_TEST_SUITE_P(
    Injected, SlowMismatch,
    testing::Values(Case{"Rate_20_0_0", "rate=20,columns=192,rows=192,seed=13"},
                    Case{"Rate_20_1_0", "rate=20,lag=1,columns=192,rows=192,seed=14"},
                    Case{"Rate_40_70_Frames_0_0", "rate=40,frames=70,columns=192,rows=192,seed=15"}),
    [](const testing::TestParamInfo<Case>& each) { return std::string(each.param.name); });

TEST(SweepHysteresis, CorrectsEachDirectionByHalf) {
  Rig rig("lag=2,moving=off,speckle=off,columns=64,rows=64");
  for (int volume = 1; volume <= 10; ++volume) {
    const Volume& newest = rig.next();
    const bool forward = newest.stamp().direction == SweepDirection::kForward;
    const double correction_deg = degrees(newest.stamp().angle_correction_rad);
    if (volume <= 5) {
      EXPECT_EQ(correction_deg, 0) << "not before there are four estimates";
    } else {
      EXPECT_NEAR(correction_deg, forward ? 1 : -1, 0.02);
      const double first_deg = degrees(newest.angles_rad()[newest.by_angle().front()]);
      EXPECT_NEAR(first_deg, -35, 0.02);
    }
  }
  EXPECT_NEAR(rig.counters().mismatch_deg.value(), 2, 0.02);
}

TEST(SweepHysteresis, SwitchedOffItLeavesTheAnglesAlone) {
  Rig rig("lag=2,columns=64,rows=64", MismatchCorrection::kOff);
  for (int volume = 1; volume <= 8; ++volume) EXPECT_EQ(rig.next().stamp().angle_correction_rad, 0);
  EXPECT_EQ(rig.counters().mismatch_estimates.value(), 0U);
}

/// Hand-made sweeps for situations that the simulated probe cannot produce.
class HandMade {
 public:
  static constexpr std::uint32_t kFrames = 12;
  explicit HandMade(const FanGeometry& geometry) : volume_(geometry, kFrames) {}

  /// `grey`: function of row, column and angle in degrees.
  template <typename Grey>
  const Volume& sweep(SweepHysteresis& mismatch, SweepDirection direction, double first_deg, Grey grey) {
    volume_.clear();
    std::vector<FrameStamp> stamps;
    for (std::uint32_t i = 0; i < kFrames; ++i) {
      const double angle_deg =
          first_deg + 3.0 * (direction == SweepDirection::kForward ? i : kFrames - 1 - i);
      stamps.push_back(
          {.direction = direction, .angle_rad = radians(angle_deg), .capture_time_ns = ++time_ns_});
      const auto pixels = volume_.next_frame_pixels();
      const FanGeometry& geometry = volume_.geometry();
      for (std::uint32_t at = 0; at < pixels.size(); ++at) {
        pixels[at] = static_cast<std::uint8_t>(grey(at / geometry.columns, at % geometry.columns, angle_deg));
      }
      volume_.add_frame(stamps.back());
    }
    volume_.sort_by_angle();
    thumbnails_.take(volume_, stamps);
    mismatch.correct(volume_, thumbnails_);
    return volume_;
  }

 private:
  Volume volume_;
  SweepThumbnails thumbnails_{kFrames};
  std::int64_t time_ns_ = 0;
};

FanGeometry small_frames(std::uint32_t rows) {
  return {.columns = 32, .rows = rows, .pixel_width_mm = 1, .pixel_height_mm = 1, .motor_radius_mm = 30};
}

double hill(std::uint32_t row, std::uint32_t column, double angle_deg) {
  return 120 + 80 * std::sin(0.2 * angle_deg + 0.3 * row) * std::cos(0.2 * column);
}

constexpr SweepDirection kThere = SweepDirection::kForward;
constexpr SweepDirection kBack = SweepDirection::kBackward;

// A recording played forward and backward repeats its own frames exactly.
TEST(SweepHysteresis, AnExactRetraceStaysAsItIs) {
  AcquisitionCounters counters;
  SweepHysteresis mismatch(HandMade::kFrames, counters);
  HandMade hand(small_frames(32));
  for (int i = 0; i < 12; ++i) {
    const Volume& volume = hand.sweep(mismatch, i % 2 == 0 ? kThere : kBack, -20, hill);
    EXPECT_EQ(volume.stamp().angle_correction_rad, 0);
  }
  EXPECT_EQ(counters.mismatch_estimates.value(), 10U);
  EXPECT_EQ(counters.mismatch_left_deg.value(), 0);
}

// The probe is tilted by 2 deg between two sweeps and stays tilted.
TEST(SweepHysteresis, ATiltIsNoMismatch) {
  AcquisitionCounters counters;
  SweepHysteresis mismatch(HandMade::kFrames, counters);
  HandMade hand(small_frames(32));
  double worst_deg = 0;
  for (int i = 0; i < 30; ++i) {
    const double tilt_deg = i < 9 ? 0 : 2;
    const auto seen = [tilt_deg](std::uint32_t row, std::uint32_t column, double angle_deg) {
      return hill(row, column, angle_deg + tilt_deg);
    };
    hand.sweep(mismatch, i % 2 == 0 ? kThere : kBack, -20, seen);
    worst_deg = std::max(worst_deg, std::abs(counters.mismatch_deg.value()));
  }
  EXPECT_LE(worst_deg, 0.1);
}

TEST(SweepHysteresis, SweepsOfOneDirectionAreNotCompared) {
  AcquisitionCounters counters;
  SweepHysteresis mismatch(HandMade::kFrames, counters);
  HandMade hand(small_frames(32));
  for (int i = 0; i < 8; ++i) hand.sweep(mismatch, kThere, -20, hill);
  EXPECT_EQ(counters.mismatch_estimates.value(), 0U);
  EXPECT_EQ(counters.mismatch_refusals.value(), 0U);
}

TEST(SweepHysteresis, RefusesWhatTellsNothing) {
  AcquisitionCounters counters;
  SweepHysteresis mismatch(HandMade::kFrames, counters);
  HandMade hand(small_frames(32));
  const auto flat = [](std::uint32_t, std::uint32_t, double) { return 50.0; };
  for (int i = 0; i < 8; ++i) hand.sweep(mismatch, i % 2 == 0 ? kThere : kBack, -20, flat);
  EXPECT_EQ(counters.mismatch_refusals.value(), 6U);
  std::uint64_t state = 1;
  const auto noise = [&state](std::uint32_t, std::uint32_t, double) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state >> 57);
  };
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(hand.sweep(mismatch, i % 2 == 0 ? kThere : kBack, -20, noise).stamp().angle_correction_rad, 0);
  }
  EXPECT_EQ(counters.mismatch_estimates.value(), 0U);
}

TEST(SweepHysteresis, RefusesSweepsOfOtherRangesAndGeometries) {
  AcquisitionCounters counters;
  SweepHysteresis mismatch(HandMade::kFrames, counters);
  HandMade hand(small_frames(32));
  for (int i = 0; i < 6; ++i) hand.sweep(mismatch, i % 2 == 0 ? kThere : kBack, i % 2 == 0 ? -30 : 0, hill);
  EXPECT_EQ(counters.mismatch_refusals.value(), 4U);
  HandMade other(small_frames(30));
  other.sweep(mismatch, kThere, -30, hill);
  EXPECT_EQ(counters.mismatch_refusals.value(), 5U);
  EXPECT_EQ(counters.mismatch_estimates.value(), 0U);
}

TEST(SweepHysteresis, BeginsAnewWhereVolumesDoNotFollowOneAnother) {
  AcquisitionCounters counters;
  SweepHysteresis mismatch(HandMade::kFrames, counters);
  HandMade hand(small_frames(32));
  const auto lagging = [](SweepDirection direction) {
    return [direction](std::uint32_t row, std::uint32_t column, double angle_deg) {
      return hill(row, column, angle_deg + (direction == kThere ? 0.75 : -0.75));
    };
  };
  for (int i = 0; i < 6; ++i)
    hand.sweep(mismatch, i % 2 == 0 ? kThere : kBack, -20, lagging(i % 2 == 0 ? kThere : kBack));
  EXPECT_NEAR(counters.mismatch_deg.value(), 1.5, 0.1);
  EXPECT_EQ(counters.mismatch_estimates.value(), 4U);
  mismatch.forget_volumes();
  const Volume& next = hand.sweep(mismatch, kThere, -20, lagging(kThere));
  EXPECT_NEAR(degrees(next.stamp().angle_correction_rad), 0.75, 0.05) << "what was found stays in force";
  EXPECT_EQ(counters.mismatch_estimates.value(), 4U);
}

}  // namespace
}  // namespace fanlight
