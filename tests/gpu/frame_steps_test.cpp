// SPDX-License-Identifier: Apache-2.0
// The steps that frames make on a slanted plane, kept and removed, against the plane itself.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::frame_steps_tests {
namespace {

constexpr FanGeometry kSlanted{.columns = 96,
                               .rows = 160,
                               .pixel_width_mm = 1,
                               .pixel_height_mm = 0.5,
                               .face_column = 47.5,
                               .face_row = 0,
                               .motor_radius_mm = 30};
constexpr PictureSize kPicture{.width = 96, .height = 96};
constexpr double kSlope = 0.7;  // mm of depth for one mm of elevation

/// Frames 2.5 deg apart: 3.5 mm at the plane.
std::vector<double> sparse_angles() {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < 21; ++frame) angles_rad.push_back(radians(2.5 * (frame - 10)));
  return angles_rad;
}

class FrameStepsTest : public GpuTest {
 protected:
  FrameStepsTest() {
    volume_.emplace(made_volume(kSlanted, sparse_angles(), [](const Point& at) {
      return 20 + 130 / (1 + std::exp(-3 * (at.y_mm - plane_mm(at.z_mm))));
    }));
    scene_ = scene_for(kSlanted, sparse_angles().front(), sparse_angles().back());
    scene_.camera.target = {.x_mm = 0, .y_mm = 50, .z_mm = 0};
    scene_.camera.distance_mm = 50;
    scene_.speckle.filter = SpeckleFilter::kNone;
    scene_.detector.place = SurfacePlace::kRefined;
    scene_.detector.window = 10;
    scene_.detector.window_mm = 0;
    scene_.detector.threshold = 30;
  }

  static double plane_mm(double elevation_mm) { return 50 + kSlope * elevation_mm; }

  std::vector<float> depths(FrameSteps steps) const {
    Scene scene = scene_;
    scene.detector.frame_steps = steps;
    RenderCounters counters;
    const auto renderer = made_renderer(kSlanted, sparse_angles(), kPicture, scene, counters);
    if (auto loaded = renderer->load(*volume_); !loaded) throw std::runtime_error(loaded.error().message);
    next_picture(*renderer);
    return renderer->read_depth()->cast_mm;
  }

  /// The root mean square of the distance from the plane, mm, less its mean, over some rows of the picture.
  double roughness_mm(const std::vector<float>& depth_mm, std::uint32_t first_row,
                      std::uint32_t end_row) const {
    const Viewport port = viewport(scene_, kPicture);
    double sum = 0;
    double squares = 0;
    double count = 0;
    for (std::uint32_t row = first_row; row < end_row; ++row) {
      for (std::uint32_t column = kPicture.width / 4; column < 3 * kPicture.width / 4; ++column) {
        const double found_mm = depth_mm[row * kPicture.width + column];
        EXPECT_GE(found_mm, 0) << row;
        const double off_mm = found_mm - plane_mm((port.centre_row() - row) * port.pixel_mm);
        sum += off_mm;
        squares += off_mm * off_mm;
        ++count;
      }
    }
    return std::sqrt(squares / count - sum * sum / (count * count));
  }

  std::optional<Volume> volume_;
  Scene scene_;
};

TEST_F(FrameStepsTest, AreRemovedFromASlantedPlane) {
  scene_.camera.field_mm = 30;
  const double kept_mm = roughness_mm(depths(FrameSteps::kKept), 0, kPicture.height);
  const double removed_mm = roughness_mm(depths(FrameSteps::kRemoved), 0, kPicture.height);
  EXPECT_GT(kept_mm, 0.15) << "there are no steps to remove";
  EXPECT_LT(removed_mm, 0.4 * kept_mm);
}

TEST_F(FrameStepsTest, LeaveTheSlopeAloneUpToTheBorderOfThePicture) {
  for (const double field_mm : {30.0, 8.0, 2.0}) {
    scene_.camera.field_mm = field_mm;
    const auto kept = depths(FrameSteps::kKept);
    const auto removed = depths(FrameSteps::kRemoved);
    for (const std::uint32_t row : {0U, kPicture.height - 8}) {
      EXPECT_LT(roughness_mm(removed, row, row + 8), roughness_mm(kept, row, row + 8) + 0.05)
          << field_mm << " mm, from row " << row;
    }
  }
}

TEST_F(FrameStepsTest, LeaveASurfaceThatOnlyANeighboursRayMeets) {
  // With one ray for 2 x 2 pixels, the crop box ends between the two columns of some of them.
  scene_.camera.field_mm = 30;
  scene_.rays.stride = 2;
  const double pixel_mm = viewport(scene_, kPicture).pixel_mm;
  scene_.crop.right_mm = (0.5 + 10) * pixel_mm + 0.1;
  const auto found = depths(FrameSteps::kRemoved);
  for (std::uint32_t row = 8; row < kPicture.height - 8; ++row) {
    for (std::uint32_t column = kPicture.width / 4; column < kPicture.width; ++column) {
      const double depth_mm = found[row * kPicture.width + column];
      EXPECT_TRUE(depth_mm < 0 || depth_mm > 30) << depth_mm << " mm at " << row << ", " << column;
    }
  }
}

}  // namespace
}  // namespace fanlight::test::frame_steps_tests
