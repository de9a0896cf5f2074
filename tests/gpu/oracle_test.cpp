// SPDX-License-Identifier: Apache-2.0
// Compares a slice through the volume, as the shaders scan convert it, with a picture of the same frame that
// independent code made (shared/data/README.md).
#include "tests/support/scan_conversion_oracle.hpp"

#include <fmt/format.h>

#include "tests/support/gpu_rig.hpp"

namespace fanlight::test::oracle_tests {
namespace {

/// A sweep whose two frames are both the given frame, so that every plane between them shows it.
Volume twice(const FanGeometry& geometry, std::span<const std::uint8_t> frame,
             std::span<const double> angles_rad) {
  Volume volume(geometry, static_cast<std::uint32_t>(angles_rad.size()));
  for (const double angle_rad : angles_rad) {
    std::ranges::copy(frame, volume.next_frame_pixels().begin());
    volume.add_frame({.angle_rad = angle_rad});
  }
  volume.sort_by_angle();
  volume.stamp().volume_id = 1;
  return volume;
}

/// The plane z = 0, +x to the right and +y down, with the pixel grid of the picture.
Scene slice_like(const FanGeometry& geometry, const FrameSequence& pictures) {
  const PlanePoint first = oracle_point(geometry, 0, 0);
  const PlanePoint last = oracle_point(geometry, pictures.columns - 1, pictures.rows - 1);
  Scene scene = scene_for(geometry, -0.1, 0.1);
  scene.mode = Mode::kSlice;
  scene.slice.depth_mm = 50;
  scene.camera = {.target = {(first.x_mm + last.x_mm) / 2, (first.depth_mm + last.depth_mm) / 2, 0},
                  .pitch_deg = -90,
                  .distance_mm = 50,
                  .field_mm = (last.depth_mm - first.depth_mm) * pictures.rows / (pictures.rows - 1.0)};
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.finish.smoothing = Smoothing::kNone;
  return scene;
}

class OracleTest : public GpuTest {};

TEST_F(OracleTest, ASliceThroughScanLinesIsTheirPicture) {
  if (!has_oracle()) {
    GTEST_SKIP() << kOracleLines << " and its pictures are not in " << data_folder()
                 << "; set FANLIGHT_DATA to their folder";
  }
  const Oracle oracle = read_oracle();
  const FanGeometry geometry = oracle_probe(oracle.lines);
  const std::vector<double> angles_rad = {-0.1, 0.1};
  const PictureSize size{.width = oracle.pictures.columns, .height = oracle.pictures.rows};
  for (std::size_t frame = 0; frame < oracle.lines.frames.size(); ++frame) {
    RenderCounters counters;
    const auto renderer =
        made_renderer(geometry, angles_rad, size, slice_like(geometry, oracle.pictures), counters);
    ASSERT_TRUE(renderer->load(twice(geometry, oracle.lines.frame_pixels(frame), angles_rad)));
    const Picture slice = next_picture(*renderer);

    const auto picture = oracle.pictures.frame_pixels(frame);
    Correlation ours;
    Correlation mirrored;
    for (std::uint32_t row = 0; row < size.height; ++row) {
      for (std::uint32_t column = 0; column < size.width; ++column) {
        const FramePlace at = geometry.frame_place(oracle_point(geometry, column, row));
        if (at.column < 0 || at.column > geometry.columns - 1 || at.row < 0 || at.row > geometry.rows - 1)
          continue;
        const auto shown = [&](std::uint32_t from) { return slice.rgba[4 * (row * size.width + from)]; };
        ours.add(shown(column), picture[row * size.width + column]);
        mirrored.add(shown(size.width - 1 - column), picture[row * size.width + column]);
      }
    }
    fmt::print("frame {}: correlation {:.5f} over {} pixels, mirrored {:.3f}\n", frame, ours.value(),
               ours.count(), mirrored.value());
    EXPECT_GT(ours.count(), 0.5 * size.width * size.height);
    EXPECT_GE(ours.value(), 0.999) << "frame " << frame;
    EXPECT_LT(mirrored.value(), 0.5) << "frame " << frame;
  }
}

}  // namespace
}  // namespace fanlight::test::oracle_tests
