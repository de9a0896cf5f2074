// SPDX-License-Identifier: Apache-2.0
// Soft light in a picture so close that nothing around a pixel is in it.
#include "proto/model/look.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::close_up_tests {
namespace {

class CloseUpTest : public GpuTest {};

TEST_F(CloseUpTest, IsLitEverywhere) {
  constexpr FanGeometry kFan{.columns = 64,
                             .rows = 64,
                             .pixel_width_mm = 1,
                             .pixel_height_mm = 1,
                             .face_column = 31.5,
                             .face_row = 0,
                             .motor_radius_mm = 30};
  std::vector<double> angles_rad;
  for (int frame = -10; frame <= 10; ++frame) angles_rad.push_back(radians(2 * frame));
  Scene scene = scene_for(kFan, angles_rad.front(), angles_rad.back());
  ASSERT_TRUE(apply_look(scene, "skin"));
  scene.light.haze = 0;
  scene.camera.field_mm = 1;
  RenderCounters counters;
  const auto renderer = made_renderer(kFan, angles_rad, {.width = 96, .height = 64}, scene, counters);
  const Volume volume =
      made_volume(kFan, angles_rad, [](const Point& at) { return at.y_mm > 30 ? 150 : 20; });
  ASSERT_TRUE(renderer->load(volume));
  const Picture picture = next_picture(*renderer);
  for (std::size_t pixel = 0; pixel < picture.rgba.size(); pixel += 4)
    ASSERT_GT(picture.rgba[pixel], 20) << "pixel " << pixel / 4;
}

}  // namespace
}  // namespace fanlight::test::close_up_tests
