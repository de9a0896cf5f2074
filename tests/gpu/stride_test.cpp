// SPDX-License-Identifier: Apache-2.0
// Pass 1 with one ray for 2 x 2 pixels: all four pixels have the bits of the ray that is cast, for seeded
// volumes, views and options.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "tests/gpu/seeded_case.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::stride_tests {
namespace {

constexpr std::uint32_t kCasesInABatch = 10;

struct Cast {
  DepthMaps depths;
  Picture picture;
};

class StrideTest : public GpuTest, public testing::WithParamInterface<std::uint32_t> {
 protected:
  /// The picture of the scene with that stride. The renderer has shown the other stride before, as it does in
  /// use.
  static Cast cast(const SeededCase& given, Scene scene, const Volume& volume, int stride,
                   const Casting& casting) {
    RenderCounters counters;
    scene.filter.steady = 0;
    scene.rays.stride = 3 - stride;
    const auto renderer =
        made_renderer(given.geometry, given.angles_rad, given.size, scene, counters, casting);
    if (auto loaded = renderer->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    next_picture(*renderer);
    scene.rays.stride = stride;
    renderer->show({.revision = 2, .scene = scene});
    Cast made{.depths = {}, .picture = next_picture(*renderer)};
    EXPECT_EQ(made.picture.stamp.scene_revision, 2U);
    for (const Stage stage : {Stage::kCast, Stage::kFilter, Stage::kLight, Stage::kFinish}) {
      EXPECT_GT(made.picture.stamp.stage_ms[static_cast<std::size_t>(stage)], 0);
    }
    made.depths = *renderer->read_depth();
    return made;
  }

  static std::uint32_t bits(const DepthMaps& depths, std::size_t pixel) {
    return std::bit_cast<std::uint32_t>(depths.cast_mm[pixel]);
  }
  static std::uint32_t colour(const Picture& picture, std::size_t pixel) {
    std::array<std::uint8_t, 4> rgba{};
    std::copy_n(&picture.rgba[4 * pixel], 4, rgba.begin());
    return std::bit_cast<std::uint32_t>(rgba);
  }

  /// The pixel whose ray this pixel shows: the first of four in the viewport.
  static std::size_t source(const SeededCase& given, const Viewport& port, std::size_t pixel) {
    const std::uint32_t column =
        std::max(static_cast<std::uint32_t>(pixel % given.size.width) & ~1U, port.left);
    const std::uint32_t row = std::max(static_cast<std::uint32_t>(pixel / given.size.width) & ~1U, port.top);
    return std::size_t{row} * given.size.width + column;
  }
  static bool in_view(const SeededCase& given, const Viewport& port, std::size_t pixel) {
    const auto column = static_cast<std::uint32_t>(pixel % given.size.width);
    const auto row = static_cast<std::uint32_t>(pixel / given.size.width);
    return column - port.left < port.width && row - port.top < port.height;
  }
};

TEST_P(StrideTest, CastsTheRaysOfEveryOtherPixelAndShowsThemInItsNeighbours) {
  std::size_t surfaces = 0;
  for (std::uint32_t seed = GetParam(); seed < GetParam() + kCasesInABatch; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    SeededCase given = seeded_case(seed);
    // The rays alone: the mean over one frame spacing takes each pixel.
    given.scene.detector.frame_steps = FrameSteps::kKept;
    const Volume volume = made_volume(given.geometry, given.angles_rad, given.grey);
    const Casting casting = way_of_casting(seed);
    Casting sampling_all = casting;
    sampling_all.skipping = Skipping::kOff;
    const Cast full = cast(given, given.scene, volume, 1, casting);
    const Cast coarse = cast(given, given.scene, volume, 2, casting);
    const Cast plain = cast(given, given.scene, volume, 2, sampling_all);
    const Viewport port = viewport(given.scene, given.size);
    std::size_t others = 0;
    for (std::size_t pixel = 0; pixel < full.depths.cast_mm.size(); ++pixel) {
      const std::size_t of = in_view(given, port, pixel) ? source(given, port, pixel) : pixel;
      others += bits(coarse.depths, pixel) != bits(full.depths, of) ? 1U : 0U;
      others += bits(plain.depths, pixel) != bits(full.depths, of) ? 1U : 0U;
      surfaces += coarse.depths.cast_mm[pixel] >= 0 ? 1U : 0U;
    }
    EXPECT_EQ(others, 0U);
    EXPECT_EQ(coarse.picture.rgba, plain.picture.rgba);
  }
  EXPECT_GT(surfaces, 1000U) << "too little was seen to prove anything";
}

TEST_P(StrideTest, ShowsTheVolumesColoursOfThoseRays) {
  const SeededCase given = seeded_case(GetParam());
  const Volume volume = made_volume(given.geometry, given.angles_rad, given.grey);
  for (const Mode mode : {Mode::kVolume, Mode::kSurfaceAndVolume, Mode::kMinimum}) {
    Scene scene = given.scene;
    scene.mode = mode;
    scene.finish.smoothing = Smoothing::kNone;
    scene.finish.colours = ColourMap::kNone;
    const Cast full = cast(given, scene, volume, 1, {});
    const Cast coarse = cast(given, scene, volume, 2, {});
    const Viewport port = viewport(scene, given.size);
    const std::uint32_t from = mode == Mode::kSurfaceAndVolume ? port.width : 0;
    std::size_t others = 0;
    for (std::size_t pixel = 0; pixel < full.depths.cast_mm.size(); ++pixel) {
      // In the half that shows the volume, a pixel shows the ray that lies this number of columns before it.
      if (pixel % given.size.width < from || pixel % given.size.width >= from + port.width) continue;
      const std::size_t of = source(given, port, pixel - from) + from;
      others += colour(coarse.picture, pixel) != colour(full.picture, of) ? 1U : 0U;
    }
    EXPECT_EQ(others, 0U) << static_cast<int>(mode);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, StrideTest, testing::Range(0U, 60U, kCasesInABatch));

}  // namespace
}  // namespace fanlight::test::stride_tests
