// SPDX-License-Identifier: Apache-2.0
// Compares a few small pictures of the simulated probe with recorded ones. `tests/golden/update` renders new
// ones and shows both side by side.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <ostream>

#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "proto/images/image_library.hpp"
#include "proto/model/look.hpp"
#include "server/cli/picture_file.hpp"
#include "tests/support/gpu_rig.hpp"

namespace fanlight::test {
namespace {

/// A picture and its tolerances. GPUs differ in rounding and in texture filtering.
struct Golden {
  std::string name;
  std::string phantom;
  std::function<void(Scene&)> set_up;
  double mean_levels;    ///< mean absolute difference, of 255
  double share_of_more;  ///< share of the values that may differ by more than 24
};

void PrintTo(const Golden& golden, std::ostream* out) {
  *out << golden.name;
}

constexpr const char* kSpeckled = "columns=256,rows=256";
constexpr const char* kSmooth = "columns=256,rows=256,speckle=off,frames=70,moving=off";

constexpr const char* kFetus = "scene=face,probe=r2,moving=off";

Golden of_look(std::string_view look) {
  return {fmt::format("fetus_in_{}", look), kFetus,
          [look](Scene& scene) { ASSERT_TRUE(apply_look(scene, look)); }, 1.0, 0.01};
}

Golden of_mode(std::string name, Mode mode) {
  return {std::move(name), kSmooth, [mode](Scene& scene) { scene.mode = mode; }, 1.0, 0.01};
}

const Golden kGoldens[] = {
    of_look("skin"),
    of_look("clinical"),
    of_look("paper"),
    {"fetus_lit_from_behind", kFetus,
     [](Scene& scene) {
       scene.light.right_mm = 60;
       scene.light.up_mm = -10;
       scene.light.depth_mm = 95;
     },
     1.0, 0.01},
    {"face", kSpeckled, [](Scene&) {}, 1.0, 0.01},
    {"face_from_the_side", kSpeckled,
     [](Scene& scene) {
       scene.camera.yaw_deg = 35;
       scene.camera.pitch_deg = 10;
       scene.camera.roll_deg = -15;
     },
     1.0, 0.01},
    {"face_in_perspective", kSmooth,
     [](Scene& scene) {
       scene.camera.projection = Projection::kPerspective;
       scene.camera.opening_deg = 60;
       scene.camera.yaw_deg = -30;
     },
     1.0, 0.01},
    {"face_of_convex_lines", "columns=192,rows=256,scan=convex", [](Scene&) {}, 1.0, 0.01},
    {"face_of_linear_lines", "columns=192,rows=256,scan=linear", [](Scene&) {}, 1.0, 0.01},
    {"face_by_the_papers_method", "columns=256,rows=256,compression=linear",
     [](Scene& scene) {
       ASSERT_TRUE(apply_look(scene, "paper"));
       scene.speckle.filter = SpeckleFilter::kNone;
       scene.detector = {.window = 8, .place = SurfacePlace::kFirstCrossing};
       scene.filter = {.kind = DepthFilter::kMean, .size = 19, .islands = 1, .holes = 1};
       scene.light.normals = Normals::kThreeNeighbours;
       scene.shadow.softness_mm = 0;
     },
     1.0, 0.01},
    {"smooth_face_with_hard_shadows", kSmooth,
     [](Scene& scene) {
       scene.light.right_mm = 120;
       scene.light.up_mm = 20;
       scene.light.depth_mm = 40;
       scene.shadow.coefficient = 0.2;
       scene.shadow.softness_mm = 0;
       scene.finish.smoothing = Smoothing::kNone;
     },
     1.0, 0.01},
    {"smooth_face_under_a_blue_sky", kSmooth,
     [](Scene& scene) {
       scene.light.kind = LightKind::kDirectional;
       scene.light.red = 0.6;
       scene.light.green = 0.8;
       scene.light.up_mm = 150;
       scene.shadow.softness_mm = 60;
       scene.shadow.coefficient = 0.2;
     },
     1.0, 0.01},
    {"face_cropped_and_clipped", kSmooth,
     [](Scene& scene) {
       scene.crop.above_mm = 25;
       scene.clip1 = {.normal_x = 1, .normal_y = 0, .normal_z = 1, .distance_mm = -20};
     },
     1.0, 0.01},
    {"face_diffused_in_sepia", kSpeckled,
     [](Scene& scene) {
       scene.finish = {.smoothing = Smoothing::kDiffusion, .iterations = 15, .colours = ColourMap::kSepia};
     },
     1.0, 0.01},
    of_mode("volume", Mode::kVolume),
    of_mode("surface_and_volume", Mode::kSurfaceAndVolume),
    of_mode("maximum", Mode::kMaximum),
    {"minimum", kSmooth,
     [](Scene& scene) {
       scene.mode = Mode::kMinimum;
       scene.crop.near_mm = 100;  // below the skin: otherwise only fluid would be visible
       scene.crop.far_mm = 115;
     },
     1.0, 0.01},
    of_mode("mean", Mode::kMean),
    of_mode("depth", Mode::kDepth),
    {"slice", kSpeckled,
     [](Scene& scene) {
       scene.mode = Mode::kSlice;
       scene.slice.depth_mm = 100;
       scene.finish.colours = ColourMap::kGold;
     },
     1.0, 0.01},
    {"tomography", kSpeckled,
     [](Scene& scene) {
       scene.mode = Mode::kTomography;
       scene.camera.target.y_mm = 100;
       scene.slice.plane = SlicePlane::kC;
     },
     1.0, 0.01},
    {"slices", kSpeckled,
     [](Scene& scene) {
       scene.mode = Mode::kSlices;
       scene.camera.target.y_mm = 100;
     },
     1.0, 0.01},
};

std::string golden_path(const Golden& golden) {
  return fmt::format("{}/{}.png", FANLIGHT_GOLDEN_FOLDER, golden.name);
}

/// The RGB values of the recorded picture; empty if the file does not exist.
std::vector<std::uint8_t> read_rgb(const std::string& path) {
  const auto library = image_library();
  if (!library) return {};
  const auto file = (*library)->open(path);
  if (!file) return {};
  const ImageShape shape = (*file)->shape();
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(shape.width) *
                                static_cast<std::size_t>(shape.height) * 3);
  if (shape.channels != 3 || !(*file)->read(1, rgb)) return {};
  return rgb;
}

class GoldenTest : public GpuTest, public testing::WithParamInterface<Golden> {
 protected:
  static Picture render(const Golden& golden) {
    const auto config = parse_phantom(golden.phantom, {.pace = PhantomSource::Pace::kUnpaced});
    const auto source = PhantomSource::create(config.value());
    const SourceDescription& description = (*source)->description();
    Volume volume(description.geometry, description.frames_per_volume);
    std::vector<double> angles_rad;
    while (!volume.full()) {
      const auto frame = (*source)->next_frame({});
      (*source)->read_pixels(volume.next_frame_pixels(), {});
      volume.add_frame(**frame);
      angles_rad.push_back((*frame)->angle_rad);
    }
    volume.sort_by_angle();
    volume.stamp().volume_id = 1;

    Scene scene = suggested_scene(description);
    golden.set_up(scene);
    RenderCounters counters;
    const auto renderer = made_renderer(description.geometry, angles_rad, {200, 200}, scene, counters);
    if (auto loaded = renderer->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    return next_picture(*renderer);
  }
};

TEST_P(GoldenTest, LooksAsItDid) {
  const Golden& golden = GetParam();
  const Picture picture = render(golden);
  if (const char* folder = std::getenv("FANLIGHT_GOLDEN_NEW")) {
    ASSERT_TRUE(write_picture(fmt::format("{}/{}.png", folder, golden.name), picture, {}));
    return;
  }
  const auto kept = read_rgb(golden_path(golden));
  ASSERT_EQ(kept.size(), picture.rgba.size() / 4 * 3)
      << golden_path(golden) << " is missing or of another size";
  double sum = 0;
  std::size_t more = 0;
  for (std::size_t value = 0; value < kept.size(); ++value) {
    const int difference = std::abs(picture.rgba[value / 3 * 4 + value % 3] - kept[value]);
    sum += difference;
    more += difference > 24 ? 1 : 0;
  }
  EXPECT_LE(sum / static_cast<double>(kept.size()), golden.mean_levels);
  EXPECT_LE(static_cast<double>(more) / static_cast<double>(kept.size()), golden.share_of_more);
}

INSTANTIATE_TEST_SUITE_P(Phantom, GoldenTest, testing::ValuesIn(kGoldens),
                         [](const auto& given) { return given.param.name; });

}  // namespace
}  // namespace fanlight::test
