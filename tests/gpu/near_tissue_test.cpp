// SPDX-License-Identifier: Apache-2.0
// Near tissue removed: a body behind fluid behind a layered wall, all of known shape.
#include <algorithm>
#include <cmath>

#include "proto/model/preset.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"
#include "tests/support/survey_fan.hpp"

namespace fanlight::test::near_tissue_tests {
namespace {

constexpr FanGeometry kFan{.columns = 96,
                           .rows = 160,
                           .pixel_width_mm = 1,
                           .pixel_height_mm = 0.5,
                           .face_column = 47.5,
                           .face_row = 0,
                           .motor_radius_mm = 40};
constexpr PictureSize kPicture{.width = 120, .height = 100};

std::vector<double> even_angles() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 41; ++frame) angles_rad.push_back(radians(1.5 * (frame - 20)));
  return angles_rad;
}

/// Below the probe's face, which is flat along x and round along z, mm.
double below_face_mm(const Point& at) {
  return std::hypot(at.y_mm + kFan.motor_radius_mm, at.z_mm) - kFan.motor_radius_mm;
}
double wall_end_mm(const Point& at) {
  return 14 + 2 * std::sin(at.x_mm / 9) + 1.5 * std::cos(at.z_mm / 11);
}
double body_mm(const Point& at) {
  return 40 + 4 * std::cos(at.x_mm / 14) + 3 * std::sin(at.z_mm / 12);
}

double grey_at(const Point& at) {
  const double depth_mm = below_face_mm(at);
  // Fat between skin and muscle: a wall without layers has no edge towards the probe.
  if (depth_mm < wall_end_mm(at)) return depth_mm > 3 && depth_mm < 8 ? 80 : 140;
  return 20 + 130 / (1 + std::exp(-4 * (at.y_mm - body_mm(at))));
}

class NearTissueGpuTest : public GpuTest {
 protected:
  NearTissueGpuTest() {
    volume_.emplace(made_volume(kFan, even_angles(), grey_at));
    scene_ = scene_for(kFan, even_angles().front(), even_angles().back());
    scene_.camera.field_mm = 40;
    scene_.near.tissue = NearTissueShow::kRemoved;
  }

  Picture shown(std::vector<float>& depth_mm, Skipping skipping = Skipping::kOn) const {
    RenderCounters counters;
    const auto renderer =
        made_renderer(kFan, even_angles(), kPicture, scene_, counters, {.skipping = skipping});
    if (auto loaded = renderer->load(*volume_); !loaded) throw std::runtime_error(loaded.error().message);
    Picture picture = next_picture(*renderer);
    depth_mm = renderer->read_depth()->cast_mm;
    return picture;
  }

  /// The points of the surface, transducer frame, mm.
  std::vector<Point> surface(Skipping skipping = Skipping::kOn) const {
    std::vector<float> depth_mm;
    shown(depth_mm, skipping);
    const Viewport port = viewport(scene_, kPicture);
    const ViewFrame view = view_frame(scene_.camera);
    std::vector<Point> points;
    for (std::uint32_t row = 0; row < kPicture.height; ++row) {
      for (std::uint32_t column = 0; column < kPicture.width; ++column) {
        const double depth = depth_mm[row * kPicture.width + column];
        if (depth < 0) continue;
        const glm::dvec3 at = view.centre + (column - port.centre_column()) * port.pixel_mm * view.right +
                              (port.centre_row() - row) * port.pixel_mm * view.up + depth * view.forward;
        points.push_back({at.x, at.y, at.z});
      }
    }
    return points;
  }

  static double share_on_wall(const std::vector<Point>& points) {
    const auto on_wall = std::ranges::count_if(
        points, [](const Point& at) { return below_face_mm(at) < wall_end_mm(at) + 1; });
    return static_cast<double>(on_wall) / static_cast<double>(std::max<std::size_t>(points.size(), 1));
  }

  std::optional<Volume> volume_;
  Scene scene_;
};

TEST_F(NearTissueGpuTest, HidesTheBodyUnlessItIsRemoved) {
  scene_.near.tissue = NearTissueShow::kShown;
  EXPECT_GT(share_on_wall(surface()), 0.9);
}

TEST_F(NearTissueGpuTest, IsRemovedFromEachSide) {
  for (const auto& [yaw_deg, pitch_deg] : {std::pair{0.0, 0.0}, {25.0, 0.0}, {-20.0, 20.0}, {0.0, -30.0}}) {
    scene_.camera.yaw_deg = yaw_deg;
    scene_.camera.pitch_deg = pitch_deg;
    const auto points = surface();
    ASSERT_GT(points.size(), 0.6 * kPicture.width * kPicture.height) << yaw_deg << ", " << pitch_deg;
    EXPECT_LT(share_on_wall(points), 0.005) << yaw_deg << ", " << pitch_deg;
    const auto off =
        std::ranges::count_if(points, [](const Point& at) { return std::abs(at.y_mm - body_mm(at)) > 1.5; });
    EXPECT_LT(static_cast<double>(off), 0.02 * static_cast<double>(points.size()))
        << yaw_deg << ", " << pitch_deg;
  }
}

TEST_F(NearTissueGpuTest, IsSaidInThePicture) {
  std::vector<float> depth_mm;
  EXPECT_EQ(shown(depth_mm).stamp.near_tissue, NearTissueState::kRemoved);
  // The body touches the wall.
  volume_.emplace(made_volume(kFan, even_angles(), [](const Point& at) {
    return below_face_mm(at) < wall_end_mm(at) ? 140.0 : at.y_mm < 60 ? 110.0 : 20.0;
  }));
  EXPECT_EQ(shown(depth_mm).stamp.near_tissue, NearTissueState::kNotFound);
}

TEST_F(NearTissueGpuTest, EndsElsewhereByTheShift) {
  // Into the body: its front is cut away.
  scene_.near.shift_mm = 30;
  std::vector<float> cut_mm;
  shown(cut_mm);
  scene_.near.shift_mm = 0;
  std::vector<float> whole_mm;
  shown(whole_mm);
  EXPECT_LT(std::ranges::count_if(cut_mm, [](float depth) { return depth >= 0; }),
            std::ranges::count_if(whole_mm, [](float depth) { return depth >= 0; }) / 4);
  // Before the fat's far side: the wall is back.
  scene_.near.shift_mm = -12;
  EXPECT_GT(share_on_wall(surface()), 0.8);
}

TEST_F(NearTissueGpuTest, SaysWhereItEndsBeforeTheTarget) {
  scene_.camera.target.x_mm = 6;
  scene_.camera.target.z_mm = -4;
  std::vector<float> depth_mm;
  const double end_mm = shown(depth_mm).stamp.near_end_mm;
  const Point end{6, end_mm, -4};
  EXPECT_GT(below_face_mm(end), wall_end_mm(end));
  EXPECT_LT(end_mm, body_mm(end));
  scene_.near.shift_mm = 5;
  EXPECT_NEAR(shown(depth_mm).stamp.near_end_mm, end_mm + 5, 0.3);
  scene_.camera.target.x_mm = 500;
  EXPECT_TRUE(std::isnan(shown(depth_mm).stamp.near_end_mm)) << "beside the fan";
  scene_.near.tissue = NearTissueShow::kShown;
  EXPECT_TRUE(std::isnan(shown(depth_mm).stamp.near_end_mm));
}

TEST_F(NearTissueGpuTest, IsRemovedAlikeWithoutSkipping) {
  std::vector<float> with_mm;
  std::vector<float> without_mm;
  shown(with_mm);
  shown(without_mm, Skipping::kOff);
  EXPECT_EQ(with_mm, without_mm);
}

TEST_F(NearTissueGpuTest, IsDimInThePlanesUpToALine) {
  scene_.mode = Mode::kSlices;
  scene_.camera.field_mm = 120;
  std::vector<float> depth_mm;
  const Picture removed = shown(depth_mm);
  scene_.near.tissue = NearTissueShow::kShown;
  const Picture whole = shown(depth_mm);
  // Down the middle of plane A, through the target.
  const std::uint32_t column = kPicture.width / 4;
  int dimmed = 0;
  int on_line = 0;
  int alike = 0;
  for (std::uint32_t row = 0; row < kPicture.height / 2; ++row) {
    const std::uint8_t* const now = &removed.rgba[4 * (row * kPicture.width + column)];
    const std::uint8_t* const before = &whole.rgba[4 * (row * kPicture.width + column)];
    if (before[0] == 0) continue;
    if (now[0] > before[0] + 10) {  // of an echo or of black
      ++on_line;
    } else if (now[0] < 0.6 * before[0]) {
      EXPECT_EQ(alike, 0) << "beyond the line, row " << row;
      ++dimmed;
    } else {
      EXPECT_EQ(now[0], before[0]) << row;
      ++alike;
    }
  }
  EXPECT_GE(dimmed, 3);
  EXPECT_GE(on_line, 1);
  EXPECT_LE(on_line, 4);
  EXPECT_GT(alike, 10);
}

/// From the outer side of a skull inwards, mm; near the skull.
double inside_skull_mm(const Point& at) {
  return 26 * (1 - std::hypot(at.x_mm / 34, (at.y_mm - 42) / 26, at.z_mm / 28));
}

TEST_F(NearTissueGpuTest, EndsAtTheNearSideOfASkullByThePresetForBone) {
  volume_.emplace(made_volume(kFan, even_angles(), [](const Point& at) {
    const double inside_mm = inside_skull_mm(at);
    // Fat before the skull: an edge that the preset would show first.
    if (inside_mm < 0) return below_face_mm(at) < 4 ? 170.0 : 110.0;
    return inside_mm < 3 ? 170.0 : 50.0;
  }));
  apply_preset(scene_, *std::ranges::find(presets(), "bone", &Preset::name));
  scene_.near.tissue = NearTissueShow::kShown;
  std::vector<float> depth_mm;
  EXPECT_EQ(shown(depth_mm).stamp.near_tissue, NearTissueState::kRemovedToBone);
  const auto points = surface();
  ASSERT_GT(points.size(), 0.5 * kPicture.width * kPicture.height);
  const auto off = std::ranges::count_if(points, [](const Point& at) {
    const double inside_mm = inside_skull_mm(at);
    return at.y_mm > 42 || inside_mm < -1.5 || inside_mm > 4.5;
  });
  EXPECT_LT(static_cast<double>(off), 0.02 * static_cast<double>(points.size()));

  volume_.emplace(
      made_volume(kFan, even_angles(), [](const Point& at) { return 110 + 30 * position_noise(at); }));
  EXPECT_EQ(shown(depth_mm).stamp.near_tissue, NearTissueState::kNoBone);
}

TEST_F(NearTissueGpuTest, EndsInFluidByThePresetForBoneWhereThereIsNoSkull) {
  // Next to its end the wall is in the detector's window, and the fluid behind it is darker. Farther on lies
  // a bone.
  volume_.emplace(made_volume(kFan, even_angles(),
                              [](const Point& at) { return at.y_mm < body_mm(at) + 8 ? grey_at(at) : 20; }));
  scene_.camera.field_mm = 90;
  apply_preset(scene_, *std::ranges::find(presets(), "bone", &Preset::name));
  scene_.near.tissue = NearTissueShow::kShown;
  std::vector<float> depth_mm;
  EXPECT_EQ(shown(depth_mm).stamp.near_tissue, NearTissueState::kRemoved);
  const auto points = surface();
  EXPECT_GT(points.size(), 0.4 * kPicture.width * kPicture.height);
  for (const Point& at : points) EXPECT_GT(at.y_mm, 25) << at.x_mm << " " << at.z_mm;
}

}  // namespace
}  // namespace fanlight::test::near_tissue_tests
