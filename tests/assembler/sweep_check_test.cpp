// SPDX-License-Identifier: Apache-2.0
// Sweeps of the simulated probe without and with faults that no stamp tells.
#include "acquisition/assembly/sweep_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "acquisition/offline_volumes.hpp"
#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

/// A frame of a made sweep: its pixels are those of another sweep's frame.
struct Placed {
  std::size_t from = 0;  ///< frame of the original, by angle
  double angle_rad = 0;
};
using Sweep = std::vector<Placed>;
using Fault = std::function<void(Sweep&)>;
/// Row, and column, of a pixel in a frame.
using Grey = std::function<double(std::uint32_t frame, std::uint32_t row, std::uint32_t column)>;

/// Two volumes of a simulated probe.
class SweepCheckTest : public testing::Test {
 protected:
  explicit SweepCheckTest(
      const std::string& source = "phantom:scene=face,probe=r1,columns=96,rows=160,volumes=2")
      : source_(open_source(source, {.pace = SourcePace::kAsFastAsTaken}, probe_).value()),
        check_(source_->description().frames_per_volume) {
    OfflineVolumes volumes(*source_);
    for (;;) {
      const auto lease = volumes.next().value();
      if (!lease) break;
      originals_.push_back(std::make_unique<Volume>(lease->geometry(), lease->stamp().frames));
      EXPECT_TRUE(originals_.back()->copy_from(*lease));
      originals_.back()->sort_by_angle();
    }
  }

  const FanGeometry& geometry() const { return originals_[0]->geometry(); }

  /// What the check says of this original with this fault.
  SweepWarnings warnings(const Fault& fault = {}, std::size_t of = 0) {
    const Volume& original = *originals_[of];
    Sweep sweep;
    for (const std::uint32_t frame : original.by_angle())
      sweep.push_back({.from = frame, .angle_rad = original.angles_rad()[frame]});
    if (fault) fault(sweep);
    Volume made(original.geometry(), static_cast<std::uint32_t>(sweep.size()));
    for (const Placed& placed : sweep) {
      std::ranges::copy(original.frame_pixels(static_cast<std::uint32_t>(placed.from)),
                        made.next_frame_pixels().begin());
      made.add_frame({.angle_rad = placed.angle_rad});
    }
    return checked(made);
  }

  /// Of frames that are drawn here, with the geometry and the angles of the original.
  SweepWarnings drawn(const Grey& grey) {
    const Volume& original = *originals_[0];
    Volume made(original.geometry(), original.stamp().frames);
    for (std::uint32_t i = 0; i < original.stamp().frames; ++i) {
      const auto pixels = made.next_frame_pixels();
      for (std::uint32_t at = 0; at < pixels.size(); ++at) {
        const double level = grey(i, at / geometry().columns, at % geometry().columns);
        pixels[at] = static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
      }
      made.add_frame({.angle_rad = original.angles_rad()[original.by_angle()[i]]});
    }
    return checked(made);
  }

  SweepWarnings checked(Volume& made) {
    made.sort_by_angle();
    const std::vector<FrameStamp> stamps(made.stamp().frames);
    SweepThumbnails thumbnails(source_->description().frames_per_volume);
    thumbnails.take(made, stamps);
    return check_.check(made, thumbnails);
  }

  /// Distance of a pixel from the apex of the probe, mm.
  double radius_mm(std::uint32_t row, std::uint32_t column) const {
    const PlanePoint at = geometry().plane_point({double(column), double(row)});
    return std::hypot(at.x_mm, at.depth_mm + geometry().probe_radius_mm);
  }
  double ring(std::uint32_t row, std::uint32_t column) {
    const double deep_mm = radius_mm(row, column) - geometry().probe_radius_mm;
    return 30 + 190 * std::exp(-deep_mm / 25) * (0.5 + 0.5 * std::cos(deep_mm)) + noise_(random_);
  }

  Doorbell bell_;
  ProbeLink probe_{bell_, bell_};
  std::unique_ptr<FrameSource> source_;
  std::vector<std::unique_ptr<Volume>> originals_;
  SweepCheck check_;
  std::mt19937 random_{7};
  std::normal_distribution<double> noise_{0, 12};
};

SweepWarnings only(SweepWarning warning) {
  SweepWarnings warnings;
  warnings.add(warning);
  return warnings;
}

/// Turns the frames' content round, so that each shows what lies at the opposite angle.
void mirror(Sweep& sweep) {
  for (std::size_t i = 0; i < sweep.size() / 2; ++i)
    std::swap(sweep[i].from, sweep[sweep.size() - 1 - i].from);
}

TEST_F(SweepCheckTest, GoodSweepsHaveNoWarning) {
  EXPECT_TRUE(warnings().empty());
  EXPECT_TRUE(warnings({}, 1).empty());
}

TEST_F(SweepCheckTest, AFrozenPictureIsSeen) {
  EXPECT_EQ(warnings([](Sweep& sweep) {
              for (Placed& placed : sweep) placed.from = sweep[3].from;
            }),
            only(SweepWarning::kCopies));
  // From the middle of a sweep on.
  EXPECT_EQ(warnings([](Sweep& sweep) {
              for (std::size_t i = sweep.size() / 2; i < sweep.size(); ++i)
                sweep[i].from = sweep[sweep.size() / 2].from;
            }),
            only(SweepWarning::kCopies));
}

TEST_F(SweepCheckTest, FramesOutOfOrderAreSeen) {
  const auto shuffle = [this](Sweep& sweep) {
    std::vector<std::size_t> from;
    for (const Placed& placed : sweep) from.push_back(placed.from);
    std::ranges::shuffle(from, random_);
    for (std::size_t i = 0; i < from.size(); ++i) sweep[i].from = from[i];
  };
  for (int i = 0; i < 10; ++i) {
    check_.forget_volumes();
    EXPECT_EQ(warnings(shuffle), only(SweepWarning::kOutOfOrder));
  }
}

TEST_F(SweepCheckTest, ASlipOfTheMotorIsSeen) {
  // The last frames show what lies three frames further, 6 deg.
  const auto slip = [](Sweep& sweep) {
    const std::size_t middle = sweep.size() / 2;
    for (std::size_t i = middle; i + 3 < sweep.size(); ++i) sweep[i].from = sweep[i + 3].from;
    sweep.resize(sweep.size() - 3);
  };
  EXPECT_EQ(warnings(slip), only(SweepWarning::kJump));
}

TEST_F(SweepCheckTest, AStepOfTheAngleExplainsAChange) {
  const auto leave_out = [](Sweep& sweep) {
    const auto middle = sweep.begin() + static_cast<std::ptrdiff_t>(sweep.size() / 2);
    sweep.erase(middle, middle + 1);
  };
  EXPECT_TRUE(warnings(leave_out).empty());
}

TEST_F(SweepCheckTest, FewFramesAreSaidToBeFew) {
  const auto every_fifth = [](Sweep& sweep) {
    for (std::size_t i = 0; 5 * i < sweep.size(); ++i) sweep[i] = sweep[5 * i];
    sweep.resize((sweep.size() + 4) / 5);
  };
  EXPECT_EQ(warnings(every_fifth), only(SweepWarning::kSparse));
}

TEST_F(SweepCheckTest, AMirroredSecondSweepIsSeen) {
  EXPECT_TRUE(warnings().empty());
  EXPECT_TRUE(warnings(mirror, 1).empty()) << "once may be a body that moved";
  EXPECT_EQ(warnings({}, 0), only(SweepWarning::kMirrored));
  EXPECT_EQ(warnings(mirror, 1), only(SweepWarning::kMirrored));
  EXPECT_EQ(warnings({}, 1), only(SweepWarning::kMirrored));
  EXPECT_TRUE(warnings({}, 0).empty());
  check_.forget_volumes();
  EXPECT_TRUE(warnings(mirror).empty()) << "nothing is known of the sweep before";
}

TEST_F(SweepCheckTest, RingsOfAProbeInAirAreSeen) {
  EXPECT_EQ(
      drawn([this](std::uint32_t, std::uint32_t row, std::uint32_t column) { return ring(row, column); }),
      only(SweepWarning::kRings));
}

TEST_F(SweepCheckTest, AThinSlantedSheetBehindRingsIsABody) {
  const auto grey = [this](std::uint32_t frame, std::uint32_t row, std::uint32_t column) {
    const double deep_mm = radius_mm(row, column) - geometry().probe_radius_mm;
    const bool on_sheet = std::abs(deep_mm - 60 - frame - 0.1 * column) < 1.2;
    return on_sheet ? 200 : ring(row, column);
  };
  EXPECT_TRUE(drawn(grey).empty());
}

TEST_F(SweepCheckTest, APlateInABathIsABody) {
  const auto grey = [this](std::uint32_t, std::uint32_t row, std::uint32_t column) {
    const double deep_mm = radius_mm(row, column) - geometry().probe_radius_mm;
    return deep_mm > 80 ? 180 + noise_(random_) : 20 + noise_(random_) / 4;
  };
  EXPECT_TRUE(drawn(grey).empty());
}

TEST_F(SweepCheckTest, NoiseAloneHasNoOrderToBreak) {
  EXPECT_TRUE(
      drawn([this](std::uint32_t, std::uint32_t, std::uint32_t) { return 100 + noise_(random_); }).empty());
}

TEST_F(SweepCheckTest, FramesOfOneLevelAreSeen) {
  EXPECT_EQ(drawn([this](std::uint32_t frame, std::uint32_t row, std::uint32_t column) {
              return frame == 4 ? 0 : ring(row, column) + 100 * std::sin(0.3 * frame + 0.2 * column);
            }),
            only(SweepWarning::kBlank));
}

TEST_F(SweepCheckTest, BlankAndDarkEndsOfASweepAreUsual) {
  const auto body = [this](std::uint32_t frame, std::uint32_t row, std::uint32_t column) {
    return ring(row, column) + 100 * std::sin(0.12 * frame + 0.2 * column);
  };
  EXPECT_TRUE(drawn([&](std::uint32_t frame, std::uint32_t row, std::uint32_t column) {
                return frame < 2 ? 0 : body(frame, row, column);
              }).empty());
  EXPECT_TRUE(drawn([&](std::uint32_t frame, std::uint32_t row, std::uint32_t column) {
                return frame > 27 ? 10 + noise_(random_) / 4 : body(frame, row, column);
              }).empty());
}

TEST_F(SweepCheckTest, ADimBodyBehindABrightLensIsABody) {
  const auto grey = [this](std::uint32_t, std::uint32_t row, std::uint32_t column) {
    const double deep_mm = radius_mm(row, column) - geometry().probe_radius_mm;
    if (deep_mm < 20) return 255.0;
    const bool in_body = std::abs(deep_mm - 80) < 20 && std::abs(column - 48.0) < 15;
    return (in_body ? 60 : 8) + noise_(random_) / 6;
  };
  EXPECT_TRUE(drawn(grey).empty());
}

/// The same scenes by other probes and seeds.
class GoodSweepTest : public testing::TestWithParam<const char*> {};

TEST_P(GoodSweepTest, HasNoWarning) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  const auto source = open_source(GetParam(), {.pace = SourcePace::kAsFastAsTaken}, probe).value();
  OfflineVolumes volumes(*source);
  for (int i = 0; i < 3; ++i) {
    const auto lease = volumes.next().value();
    ASSERT_TRUE(lease);
    lease->stamp().warnings.for_each([](const SweepWarningText& text) { ADD_FAILURE() << text.sentence; });
  }
}

INSTANTIATE_TEST_SUITE_P(Probes, GoodSweepTest,
                         testing::Values("phantom:scene=relief,probe=r1,columns=96,rows=160",
                                         "phantom:scene=relief,probe=r2,columns=96,rows=160",
                                         "phantom:scene=relief,probe=r1,columns=96,rows=160,seed=5",
                                         "phantom:scene=relief,probe=r1,rate=20,speckle=off",
                                         "phantom:scene=face,probe=r1,columns=96,rows=160,speckle=off",
                                         "phantom:scene=face,probe=r2,columns=96,rows=160",
                                         "phantom:scene=face,probe=r1,columns=96,rows=160,seed=5"));

/// What becomes of the warnings in the assembler.
class WarnedVolumeTest : public AssemblerTest {};

TEST_F(WarnedVolumeTest, IsCountedAndStamped) {
  add_sweep(0, 5, 5);  // each frame of a level of its own
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_TRUE(volume->stamp().warnings.has(SweepWarning::kBlank));
  EXPECT_EQ(counters_.volumes_blank.value(), 1u);
  EXPECT_EQ(counters_.volumes_copied.value(), 0u);
}

class UnjudgedVolumeTest : public AssemblerTest {
 protected:
  UnjudgedVolumeTest() : AssemblerTest({.config = {.checks_sweeps = false}}) {}
};

TEST_F(UnjudgedVolumeTest, PlanesOfAGridAreNotJudged) {
  add_sweep(0, 5, 5);
  const auto volume = ring_.take();
  ASSERT_TRUE(volume);
  EXPECT_TRUE(volume->stamp().warnings.empty());
  EXPECT_EQ(counters_.volumes_blank.value(), 0u);
}

}  // namespace
}  // namespace fanlight
