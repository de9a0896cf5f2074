// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/phantom/phantom_options.hpp"
#include "tests/unit/phantom_frames.hpp"

namespace fanlight::test {
namespace {

// A beam without thickness, so that a slanted surface is as sharp as a flat one.
constexpr PhantomSource::Config kStill = {.beam_mm = 0,
                                          .speckle = PhantomSource::Speckle::kOff,
                                          .clutter = PhantomSource::Clutter::kOff,
                                          .scale = {.kind = EchoScale::Kind::kLinear},
                                          .motion = PhantomScene::Motion::kStill,
                                          .pace = PhantomSource::Pace::kUnpaced};
constexpr PhantomSource::Config kPlain = {.beam_mm = 0,
                                          .speckle = PhantomSource::Speckle::kOff,
                                          .clutter = PhantomSource::Clutter::kOff,
                                          .scale = {.kind = EchoScale::Kind::kLinear},
                                          .pace = PhantomSource::Pace::kUnpaced};

/// Row at which the true surface crosses a column or scan line of a frame, from a fine search of the scene.
std::optional<double> true_row(const PhantomSource& source, const FrameStamp& stamp, double column) {
  const FanGeometry& geometry = source.description().geometry;
  const double time_s = source.scene_time_s(stamp);
  const double step = 0.005 / geometry.pixel_height_mm;
  for (double row = 40 / geometry.pixel_height_mm; row < geometry.rows - 1; row += step) {
    const PlanePoint at = geometry.plane_point({column, row});
    const Point point = geometry.point(at.x_mm, {.angle_rad = stamp.angle_rad, .depth_mm = at.depth_mm});
    if (point.y_mm >= source.scene().surface_depth_mm(point.x_mm, point.z_mm, time_s)) return row;
  }
  return std::nullopt;
}

/// Row, interpolated between pixels, of the first rise through the middle between fluid and skin.
std::optional<double> seen_row(const FanGeometry& geometry, const Frame& frame, std::uint32_t column) {
  constexpr double kMiddle = 93;
  const auto grey = [&](std::uint32_t row) {
    return double{1} * frame.pixels[row * geometry.columns + column];
  };
  for (std::uint32_t row = 1; row < geometry.rows; ++row) {
    if (grey(row) < kMiddle) continue;
    return row - 1 + (kMiddle - grey(row - 1)) / (grey(row) - grey(row - 1));
  }
  return std::nullopt;
}

std::string scan_name(const testing::TestParamInfo<FrameKind>& scan) {
  constexpr const char* kNames[] = {"Cartesian", "Convex", "Linear"};
  return kNames[static_cast<int>(scan.param)];
}

class PhantomScan : public testing::TestWithParam<FrameKind> {};

INSTANTIATE_TEST_SUITE_P(OfEachKind, PhantomScan,
                         testing::Values(FrameKind::kCartesian, FrameKind::kConvexLines,
                                         FrameKind::kLinearLines),
                         scan_name);

// The true surface that other tests compare with must be the one in the frames: at many angles, in both
// directions, at different times of the moving scene.
TEST_P(PhantomScan, StepsUpWhereTheTrueSurfaceIs) {
  auto config = kPlain;
  config.scan = GetParam();
  const auto source = make(config);
  ASSERT_NE(source, nullptr);
  const FanGeometry& geometry = source->description().geometry;
  int compared = 0;
  std::set<std::pair<SweepDirection, double>> angles;
  for (int i = 0; i < 160; ++i) {
    if (i % 6 != 0) {
      next_stamp(*source);
      continue;
    }
    const Frame frame = next(*source);
    for (std::uint32_t column = 100; column <= 410; column += 31) {
      const auto truth = true_row(*source, frame.stamp, column);
      const auto seen = seen_row(geometry, frame, column);
      // Where the column only touches the edge of the head, the first pixel inside has no well-defined depth.
      const auto beside = true_row(*source, frame.stamp, column + 0.02 * (column - geometry.face_column));
      if (!truth || !beside || std::abs(*truth - *beside) > 10) continue;
      ASSERT_TRUE(seen) << "column " << column << " of frame " << frame.stamp.sequence;
      EXPECT_NEAR(*seen, *truth, 1) << "column " << column << " of frame " << frame.stamp.sequence;
      ++compared;
      angles.emplace(frame.stamp.direction, frame.stamp.angle_rad);
    }
  }
  EXPECT_GT(compared, 80);
  EXPECT_GT(angles.size(), 15U);
}

TEST_P(PhantomScan, SeesTheFaceExactlyWhereTheSceneHasIt) {
  auto config = kStill;
  config.scan = GetParam();
  const auto source = make(config);
  ASSERT_NE(source, nullptr);
  const FanGeometry& geometry = source->description().geometry;
  for (int i = 0; i < 35; ++i) {
    const Frame frame = next(*source);
    EXPECT_EQ(true_row(*source, frame.stamp, 255).has_value(), seen_row(geometry, frame, 255).has_value())
        << "frame " << i;
  }
}

TEST(Phantom, ScansTheSameFieldInLines) {
  auto config = kSpeckled;
  config.columns = 192;
  config.rows = 640;
  config.scan = FrameKind::kConvexLines;
  const auto convex = make(config);
  config.scan = FrameKind::kLinearLines;
  const auto linear = make(config);
  ASSERT_NE(convex, nullptr);
  ASSERT_NE(linear, nullptr);

  const FanGeometry& fan = convex->description().geometry;
  EXPECT_TRUE(check(fan));
  EXPECT_EQ(fan.kind, FrameKind::kConvexLines);
  EXPECT_EQ(fan.probe_radius_mm, 50);
  EXPECT_NEAR(degrees(fan.line_angle_rad(0)), -35, 1e-9);
  EXPECT_NEAR(degrees(fan.line_angle_rad(191)), 35, 1e-9);
  EXPECT_DOUBLE_EQ(fan.pixel_height_mm, 0.25);
  EXPECT_EQ(fan.face_row, 0);

  const FanGeometry& box = linear->description().geometry;
  EXPECT_TRUE(check(box));
  EXPECT_EQ(box.kind, FrameKind::kLinearLines);
  EXPECT_DOUBLE_EQ(box.pixel_width_mm * 192, 160);
  EXPECT_DOUBLE_EQ(box.left_mm(), -box.right_mm());
  EXPECT_DOUBLE_EQ(box.pixel_height_mm, 0.25);

  // A line has echo along its whole length; the corners of a scan-converted frame have none.
  for (const auto& source : {&convex, &linear}) {
    const Frame frame = next(**source);
    const double mean = std::accumulate(frame.pixels.begin(), frame.pixels.begin() + 192 * 100, 0.0) / 19'200;
    EXPECT_NEAR(mean, 6, 0.5);
  }
}

TEST(Phantom, TheFaceFillsTheViewAndLooksAtTheProbe) {
  const PhantomScene scene(PhantomScene::Motion::kStill);
  const auto depth = [&](double x_mm, double z_mm) { return scene.surface_depth_mm(x_mm, z_mm, 0); };
  const double nose = depth(0, -8);
  EXPECT_NEAR(nose, 76, 3);
  for (const double x : {-50.0, 50.0}) EXPECT_LT(depth(x, 0), 130);
  for (const double z : {-55.0, 55.0}) EXPECT_LT(depth(0, z), 130);
  EXPECT_LT(nose, depth(9, 3)) << "the nose stands out of the cheeks";
  EXPECT_GT(depth(18, 9), depth(17, 15)) << "the sockets lie behind the brow";
  EXPECT_LT(depth(0, -30), depth(0, -36)) << "the lower lip stands out over the chin";
  EXPECT_EQ(depth(63, 0), PhantomScene::kNoSurfaceMm);
  EXPECT_EQ(depth(0, 500), PhantomScene::kNoSurfaceMm);
  EXPECT_GT(nose, scene.nearest_depth_mm());
}

TEST(Phantom, NothingIsNearerThanItSays) {
  const PhantomScene scene(PhantomScene::Motion::kMoving);
  for (double time_s = 0; time_s < 60; time_s += 0.37) {
    for (double x_mm = -60; x_mm <= 60; x_mm += 3) {
      for (double z_mm = -60; z_mm <= 60; z_mm += 3) {
        ASSERT_GE(scene.surface_depth_mm(x_mm, z_mm, time_s), scene.nearest_depth_mm());
      }
    }
  }
}

TEST(Phantom, TheSceneMovesUnlessItIsHeldStill) {
  const PhantomScene moving(PhantomScene::Motion::kMoving);
  EXPECT_GT(std::abs(moving.surface_depth_mm(20, 20, 0) - moving.surface_depth_mm(20, 20, 1)), 0.5);
  EXPECT_LT(std::abs(moving.surface_depth_mm(20, 20, 0) - moving.surface_depth_mm(20, 20, 0.013)), 0.3);
  const PhantomScene still(PhantomScene::Motion::kStill);
  EXPECT_EQ(still.surface_depth_mm(20, 20, 0), still.surface_depth_mm(20, 20, 1));
}

TEST(Phantom, SweepsToAndFro) {
  const auto source = make(kSpeckled);
  ASSERT_NE(source, nullptr);
  const SourceDescription& description = source->description();
  EXPECT_TRUE(check(description.geometry));
  EXPECT_DOUBLE_EQ(description.geometry.pixel_width_mm, 0.3125);
  EXPECT_DOUBLE_EQ(description.geometry.face_column, 255.5);
  EXPECT_EQ(description.frames_per_volume, 35U);
  for (std::uint64_t i = 0; i < 4 * 35; ++i) {
    const FrameStamp stamp = next_stamp(*source);
    EXPECT_EQ(stamp.sequence, i);
    EXPECT_EQ(stamp.volume_index, i / 35);
    EXPECT_EQ(stamp.frame_index, i % 35);
    EXPECT_EQ(stamp.frames_in_sweep, 35U);
    EXPECT_EQ(stamp.direction, i / 35 % 2 == 0 ? SweepDirection::kForward : SweepDirection::kBackward);
    const double from_start_deg = 70.0 * static_cast<double>(i % 35) / 34;
    const bool forward = stamp.direction == SweepDirection::kForward;
    EXPECT_NEAR(degrees(stamp.angle_rad), forward ? from_start_deg - 35 : 35 - from_start_deg, 1e-9);
    EXPECT_NEAR(static_cast<double>(stamp.capture_time_ns - kSimulatedStartNs),
                1e9 / 75 * static_cast<double>(i), 1);
  }
}

TEST(Phantom, EqualSeedsGiveEqualFramesAndSkippingChangesNothing) {
  const auto first = make(kSpeckled);
  const auto second = make(kSpeckled);
  auto other_config = kSpeckled;
  other_config.seed = 2;
  const auto other = make(other_config);
  for (int i = 0; i < 20; ++i) {
    const Frame frame = next(*first);
    if (i % 5 != 0) {
      next_stamp(*second);
      next_stamp(*other);
      continue;
    }
    EXPECT_EQ(frame.pixels, next(*second).pixels);
    EXPECT_NE(frame.pixels, next(*other).pixels);
  }
}

TEST(Phantom, IsBlackOutsideTheSectorAndDarkInTheFluid) {
  const auto source = make(kSpeckled);
  ASSERT_NE(source, nullptr);
  const FanGeometry& geometry = source->description().geometry;
  const FanGeometry::Sector& sector = geometry.sector;
  const Frame frame = next(*source);
  double fluid_sum = 0;
  int fluid_pixels = 0;
  for (std::uint32_t row = 0; row < geometry.rows; ++row) {
    for (std::uint32_t column = 0; column < geometry.columns; ++column) {
      const double x_mm = (column - geometry.face_column) * geometry.pixel_width_mm;
      const double down_mm = row * geometry.pixel_height_mm + geometry.probe_radius_mm;
      const bool inside = std::abs(std::atan2(x_mm, down_mm)) <= radians(sector.half_angle_deg) &&
                          std::hypot(x_mm, down_mm) <= sector.reach_mm;
      const std::uint8_t grey = frame.pixels[row * geometry.columns + column];
      if (!inside) {
        ASSERT_EQ(grey, 0) << row << ' ' << column;
      } else if (row < 150) {
        fluid_sum += grey;
        ++fluid_pixels;
      }
    }
  }
  EXPECT_NEAR(fluid_sum / fluid_pixels, 6, 0.5);
}

/// Correlation of two frames over some rows and the columns 32 to 160.
double correlation(const Frame& one, const Frame& other, std::uint32_t columns, std::uint32_t first_row,
                   std::uint32_t end_row) {
  std::array<double, 5> sums{};  // of one, other, their squares and their product
  double count = 0;
  for (std::uint32_t row = first_row; row < end_row; ++row) {
    for (std::uint32_t column = 32; column < 160; ++column, ++count) {
      const double here = one.pixels[row * columns + column];
      const double there = other.pixels[row * columns + column];
      const std::array<double, 5> terms = {here, there, here * here, there * there, here * there};
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += terms[i];
    }
  }
  for (double& sum : sums) sum /= count;
  const auto [mean, other_mean, square, other_square, product] = sums;
  return (product - mean * other_mean) /
         std::sqrt((square - mean * mean) * (other_square - other_mean * other_mean));
}

// The beam covers two frames near the probe, and hardly so far from it.
TEST(Phantom, HasSimilarSpeckleInNeighbouringFramesNearTheProbe) {
  for (const char* scene : {"plane", "relief"}) {
    // Fluid of a middle grey, down to 60 mm.
    auto config =
        *parse_phantom(fmt::format("scene={},gain=20,clutter=off,moving=off", scene), usual_phantom());
    config.pace = PhantomSource::Pace::kUnpaced;
    const auto source = make(config);
    ASSERT_NE(source, nullptr);
    std::vector<Frame> frames;
    for (std::uint32_t frame = 0; frame < 2 * config.frames_per_volume; ++frame)
      frames.push_back(next(*source));
    const Frame& middle = frames[30];
    const double near = correlation(middle, frames[31], config.columns, 0, 40);
    const double far = correlation(middle, frames[31], config.columns, 150, 190);
    EXPECT_GT(near, 0.6) << scene;
    EXPECT_LT(far, near - 0.2) << scene;
    EXPECT_GT(far, 0.05) << scene;
    // Frame 30 of the next sweep, which runs backward.
    const Frame& again = frames[2 * config.frames_per_volume - 1 - 30];
    EXPECT_NEAR(again.stamp.angle_rad, middle.stamp.angle_rad, 1e-9);
    EXPECT_NEAR(correlation(middle, again, config.columns, 0, 40), 0, 0.1) << scene;
  }
}

/// Mean and standard deviation of the grey levels in a square of tissue.
std::pair<double, double> tissue_of(const PhantomSource::Config& config) {
  const auto source = make(config);
  for (int frame = 0; frame < 17; ++frame) next_stamp(*source);
  const Frame frame = next(*source);
  double sum = 0;
  double squares = 0;
  int pixels = 0;
  for (std::uint32_t row = 400; row < 440; ++row) {
    for (std::uint32_t column = 236; column < 276; ++column, ++pixels) {
      const double grey = frame.pixels[row * config.columns + column];
      sum += grey;
      squares += grey * grey;
    }
  }
  const double mean = sum / pixels;
  return {mean, std::sqrt(squares / pixels - mean * mean)};
}

TEST(Phantom, IsLogCompressedAsScannersDoIt) {
  PhantomSource::Config config{.motion = PhantomScene::Motion::kStill, .pace = PhantomSource::Pace::kUnpaced};
  const auto [mean, deviation] = tissue_of(config);
  EXPECT_NEAR(deviation / mean, 0.18, 0.04) << "real pictures have 0.12 to 0.17 before they are filtered";
  // The logarithm of a Rayleigh distribution deviates by 5.57 dB.
  EXPECT_NEAR(deviation, 5.57 * 255 / 60, 3);
  config.scale.gain_db = 6;
  EXPECT_NEAR(tissue_of(config).first, mean + 6 * 255 / 60.0, 1);
  config.scale = {.range_db = 80};
  EXPECT_NEAR(tissue_of(config).second, 5.57 * 255 / 80, 3);
}

TEST(Phantom, TakesOtherSizesOfTheSameField) {
  auto config = kPlain;
  config.columns = 64;
  config.rows = 128;
  config.frames_per_volume = 5;
  const auto source = make(config);
  ASSERT_NE(source, nullptr);
  EXPECT_DOUBLE_EQ(source->description().geometry.pixel_width_mm, 2.5);
  EXPECT_DOUBLE_EQ(source->description().geometry.pixel_height_mm, 1.25);
  const Frame frame = next(*source);
  EXPECT_GT(*std::ranges::max_element(frame.pixels), 5);
}

TEST(Phantom, InRealTimeItLosesWhatIsNotTaken) {
  PhantomSource::Config config{.frame_rate_hz = 1000, .pace = PhantomSource::Pace::kRealTime};
  const auto source = make(config);
  ASSERT_NE(source, nullptr);
  FrameStamp last = next_stamp(*source);
  for (int i = 0; i < 20; ++i) {
    Frame frame = next(*source);  // drawing a frame takes about as long as its period
    EXPECT_GT(frame.stamp.sequence, last.sequence);
    const auto frames = static_cast<double>(frame.stamp.sequence - last.sequence);
    EXPECT_NEAR(static_cast<double>(frame.stamp.capture_time_ns - last.capture_time_ns), 1e6 * frames, 1);
    last = frame.stamp;
  }
}

TEST(Phantom, AStoppedSourceGivesNoFrame) {
  for (const auto pace : {PhantomSource::Pace::kRealTime, PhantomSource::Pace::kUnpaced}) {
    const auto source = make({.frame_rate_hz = 0.1, .pace = pace});
    std::stop_source stop;
    stop.request_stop();
    EXPECT_FALSE(source->next_frame(stop.get_token()).value().has_value());
  }
}

TEST(Phantom, EndsAfterTheVolumesAskedFor) {
  const auto source = make({.frames_per_volume = 3, .volumes = 2, .pace = PhantomSource::Pace::kUnpaced});
  ASSERT_NE(source, nullptr);
  for (int i = 0; i < 6; ++i) next_stamp(*source);
  EXPECT_FALSE(source->next_frame({}).value().has_value());
}

// Within the beam, each elevation of a slanted surface is at another depth: a thicker beam gives a less steep
// step in the frame.
TEST(Phantom, AThickBeamBlursWhatIsSlanted) {
  auto config = kStill;
  const auto thin = make(config);
  config.beam_mm = 5;
  const auto thick = make(config);
  ASSERT_NE(thin, nullptr);
  ASSERT_NE(thick, nullptr);
  const auto steepest = [](const PhantomSource& source, const Frame& frame) {
    int step = 0;
    for (std::uint32_t row = 1; row < source.description().geometry.rows; ++row) {
      const std::size_t at = row * source.description().geometry.columns + 255;
      step = std::max(step, frame.pixels[at] - frame.pixels[at - source.description().geometry.columns]);
    }
    return step;
  };
  for (int i = 0; i < 35; ++i) {
    const Frame sharp = next(*thin);
    const Frame blurred = next(*thick);
    if (i != 8) continue;  // below the chin, where the head is slanted
    const double share = static_cast<double>(steepest(*thick, blurred)) / steepest(*thin, sharp);
    EXPECT_LT(share, 0.6);
  }
}

}  // namespace
}  // namespace fanlight::test
