// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/fluid_region.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "acquisition/offline_volumes.hpp"
#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "tests/support/made_volume.hpp"
#include "tests/support/survey_fan.hpp"

namespace fanlight::test {

namespace {

constexpr Point kMiddle{2, 60, -3};

double distance_mm(const Point& a, const Point& b) {
  return std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm, a.z_mm - b.z_mm);
}

double ball_mm3(double radius_mm) {
  return 4.0 / 3 * kPi * std::pow(radius_mm, 3);
}

/// Pixels of 0.5 mm.
constexpr FanGeometry kFineFan{.columns = 192,
                               .rows = 230,
                               .pixel_width_mm = 0.5,
                               .pixel_height_mm = 0.5,
                               .face_column = 95.5,
                               .face_row = 0,
                               .motor_radius_mm = 30};

std::vector<double> fine_angles() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 81; ++frame) angles_rad.push_back(radians(0.7 * frame - 28));
  return angles_rad;
}

/// Tissue with holes of fluid, whose distances `depth_mm` gives: positive in fluid. Log-compressed, three
/// grey levels a decibel; the fluid is 50 dB below, and the power is blurred over 1 mm.
template <typename Depth>
Volume tissue_with(Depth depth_mm) {
  return made_volume(kFineFan, fine_angles(), [&](const Point& at) {
    const double in_fluid = std::clamp(depth_mm(at) + 0.5, 0.0, 1.0);
    return 170 + 30 * std::log10(std::lerp(1, 1e-5, in_fluid)) + 4 * position_noise(at);
  });
}

/// Whether the drawn border holds a point.
bool holds(const FluidRegion& region, const Point& at) {
  const auto& [first, step_mm, size] = region.box;
  const auto cell = [&](double mm, double from_mm, std::uint32_t count) {
    const double place = std::round((mm - from_mm) / step_mm);
    return place >= 0 && place < count ? static_cast<std::uint32_t>(place) : ~0U;
  };
  const std::uint32_t i = cell(at.x_mm, first.x_mm, size[0]);
  const std::uint32_t j = cell(at.y_mm, first.y_mm, size[1]);
  const std::uint32_t k = cell(at.z_mm, first.z_mm, size[2]);
  return i != ~0U && j != ~0U && k != ~0U && region.depths[region.box.index(i, j, k)] >= FluidRegion::kBorder;
}

}  // namespace

TEST(FluidRegionTest, HasTheVolumeOfABallFromAnyPointOfIt) {
  const Volume volume = tissue_with([](const Point& at) { return 14 - distance_mm(at, kMiddle); });
  for (const Point seed : {kMiddle, Point{8, 66, -5}, Point{-6, 52, -2}}) {
    const auto region = grown_fluid(volume, {.at = seed}, {});
    ASSERT_TRUE(region) << region.error().message;
    EXPECT_NEAR(region->volume_mm3, ball_mm3(14), 0.04 * ball_mm3(14));
    EXPECT_GT(region->deviation_mm3, 0);
    EXPECT_LT(region->deviation_mm3, 0.1 * ball_mm3(14));
    EXPECT_LT(region->fluid_level, region->border_level);
    EXPECT_LT(region->border_level, region->wall_level);
  }
}

TEST(FluidRegionTest, DrawsItsBorder) {
  const Volume volume = tissue_with([](const Point& at) { return 14 - distance_mm(at, kMiddle); });
  const auto region = grown_fluid(volume, {.at = kMiddle}, {});
  ASSERT_TRUE(region) << region.error().message;
  for (const std::uint32_t side : region->box.size) EXPECT_LE(side, FluidRegion::kMostCellsASide);
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        const double length = std::max(std::hypot(x, y, z), 1.0);
        const auto at = [&](double mm) {
          return Point{kMiddle.x_mm + mm * x / length, kMiddle.y_mm + mm * y / length,
                       kMiddle.z_mm + mm * z / length};
        };
        EXPECT_TRUE(holds(*region, at(13))) << x << y << z;
        EXPECT_TRUE((x == 0 && y == 0 && z == 0) || !holds(*region, at(15))) << x << y << z;
      }
    }
  }
}

TEST(FluidRegionTest, EndsAtANarrowOpening) {
  // A channel of 2 mm from the ball to another one.
  const Point other{2, 60, 27};
  const auto balls = [&](const Point& at) {
    return std::max(10 - distance_mm(at, kMiddle), 10 - distance_mm(at, other));
  };
  const Volume volume = tissue_with([&](const Point& at) {
    const bool is_between = at.z_mm > kMiddle.z_mm && at.z_mm < other.z_mm;
    const double channel = is_between ? 1 - std::hypot(at.x_mm - 2, at.y_mm - 60) : -9;
    return std::max(balls(at), channel);
  });
  const auto region = grown_fluid(volume, {.at = kMiddle}, {});
  ASSERT_TRUE(region) << region.error().message;
  EXPECT_NEAR(region->volume_mm3, ball_mm3(10), 0.06 * ball_mm3(10));
  EXPECT_FALSE(holds(*region, other));
}

TEST(FluidRegionTest, LeavesOutWhatLiesInTheFluid) {
  const Volume volume = tissue_with([](const Point& at) {
    const double from_middle = distance_mm(at, kMiddle);
    return std::min(16 - from_middle, from_middle - 7);
  });
  const auto region = grown_fluid(volume, {.at = {2, 71.5, -3}}, {});
  ASSERT_TRUE(region) << region.error().message;
  const double truth = ball_mm3(16) - ball_mm3(7);
  EXPECT_NEAR(region->volume_mm3, truth, 0.05 * truth);
}

TEST(FluidRegionTest, MeasuresLargeRegionsFromTheirMiddle) {
  const Volume volume = tissue_with([](const Point& at) { return 36 - distance_mm(at, {0, 55, 0}); });
  const auto region = grown_fluid(volume, {.at = {0, 55, 0}}, {});
  ASSERT_TRUE(region) << region.error().message;
  EXPECT_NEAR(region->volume_mm3, ball_mm3(36), 0.04 * ball_mm3(36));
}

TEST(FluidRegionTest, DrawsTheWholeBorderOfALongRegion) {
  const Volume volume = tissue_with([](const Point& at) {
    const double scaled = std::hypot(at.x_mm / 30, (at.y_mm - 60) / 4.5, at.z_mm / 4.5);
    return (1 - scaled) * 4.5;
  });
  const auto region = grown_fluid(volume, {.at = {0, 60, 0}}, {});
  ASSERT_TRUE(region) << region.error().message;
  const CellBox& box = region->box;
  for (std::uint32_t k = 0; k < box.size[2]; ++k) {
    for (std::uint32_t j = 0; j < box.size[1]; ++j) {
      for (std::uint32_t i = 0; i < box.size[0]; ++i) {
        if (box.is_inner(i, j, k)) continue;
        EXPECT_LT(region->depths[box.index(i, j, k)], FluidRegion::kBorder) << i << ' ' << j << ' ' << k;
      }
    }
  }
}

TEST(FluidRegionTest, BearsABrightReflectorInSmoothedFrames) {
  const Volume volume = made_volume(kFineFan, fine_angles(), [](const Point& at) {
    const double in_fluid = std::clamp(18 - distance_mm(at, kMiddle) + 0.5, 0.0, 1.0);
    const bool is_bright = distance_mm(at, {2, 80, -3}) < 3 && in_fluid == 0;
    return is_bright ? 255 : std::lerp(114, 60, in_fluid) + 2 * position_noise(at);
  });
  const auto region = grown_fluid(volume, {.at = kMiddle}, {});
  ASSERT_TRUE(region) << region.error().message;
  EXPECT_NEAR(region->volume_mm3, ball_mm3(18), 0.12 * ball_mm3(18));
}

TEST(FluidRegionTest, MovesItsBorderByDecibels) {
  const Volume volume = tissue_with([](const Point& at) { return 14 - distance_mm(at, kMiddle); });
  double before = 0;
  for (const double border_db : {-6.0, -3.0, 0.0, 1.5}) {
    const auto region = grown_fluid(volume, {.at = kMiddle, .border_db = border_db}, {});
    ASSERT_TRUE(region) << region.error().message;
    EXPECT_GT(region->volume_mm3, before + 50) << border_db;
    before = region->volume_mm3;
  }
}

TEST(FluidRegionTest, RefusesWhatIsNotClosedFluid) {
  const Volume ball = tissue_with([](const Point& at) { return 14 - distance_mm(at, kMiddle); });
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refusal = [&](const Point& seed) {
    const auto none = grown_fluid(ball, {.at = seed}, {});
    EXPECT_FALSE(none) << seed.y_mm;
    EXPECT_EQ(none.error().code, ErrorCode::kInvalidArgument);
    return none.error().message;
  };
  EXPECT_NE(refusal({2, 85, -3}).find("not in fluid"), std::string::npos);
  for (const Point seed : {Point{500, 0, 0}, Point{nan, nan, nan}})
    EXPECT_NE(refusal(seed).find("nothing was scanned"), std::string::npos);
  const Volume open = tissue_with([](const Point& at) { return 14 - std::hypot(at.y_mm - 60, at.z_mm); });
  const auto across = grown_fluid(open, {.at = {0, 60, 0}}, {});
  ASSERT_FALSE(across);
  EXPECT_NE(across.error().message.find("edge of the scan"), std::string::npos) << across.error().message;
  const auto stopped = [&] {
    std::stop_source source;
    source.request_stop();
    return grown_fluid(ball, {.at = kMiddle}, source.get_token());
  }();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kStopped);
}

/// Of the simulated probe's cyst, which beam, pulse, speckle, log compression and attenuation blur.
TEST(FluidRegionTest, HasTheVolumeOfTheSimulatedCyst) {
  for (const char* const options : {"scene=cyst,volumes=1", "scene=cyst,volumes=1,scan=cartesian,seed=5"}) {
    auto config = parse_phantom(options, usual_phantom());
    ASSERT_TRUE(config);
    config->pace = PhantomSource::Pace::kUnpaced;
    const auto source = PhantomSource::create(*config);
    ASSERT_TRUE(source);
    const auto [middle_mm, radius_mm] = (*source)->bodies()->far_wall();
    OfflineVolumes volumes(**source);
    const auto volume = volumes.next();
    ASSERT_TRUE(volume && *volume);
    const auto region =
        grown_fluid(**volume, {.at = {middle_mm.x + 5, middle_mm.y - 4, middle_mm.z + 3}}, {});
    ASSERT_TRUE(region) << region.error().message;
    EXPECT_NEAR(region->volume_mm3, ball_mm3(radius_mm), 0.02 * ball_mm3(radius_mm)) << options;
  }
}

}  // namespace fanlight::test
