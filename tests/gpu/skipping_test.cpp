// SPDX-License-Identifier: Apache-2.0
// Pass 1 with and without skipping of empty space: the same bits, for seeded volumes, views and options.
#include <fmt/format.h>

#include <bit>

#include "tests/gpu/seeded_case.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::skipping_tests {
namespace {

constexpr std::uint32_t kCasesInABatch = 10;

struct Cast {
  DepthMaps depths;
  Picture picture;
};

class SkippingTest : public GpuTest, public testing::WithParamInterface<std::uint32_t> {
 protected:
  static Cast cast(const SeededCase& given, const Scene& scene, const Volume& volume,
                   const Casting& casting) {
    RenderCounters counters;
    const auto renderer =
        made_renderer(given.geometry, given.angles_rad, given.size, scene, counters, casting);
    if (auto loaded = renderer->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    Cast made{.depths = {}, .picture = next_picture(*renderer)};
    made.depths = *renderer->read_depth();
    return made;
  }

  /// Fraction of segments that had to be sampled.
  static double compare(const SeededCase& given, const Scene& scene, const Casting& way) {
    const Volume volume = made_volume(given.geometry, given.angles_rad, given.grey);
    // Skipping changes no bit, whichever way buffers are read: the two casts read them differently.
    Casting all = way;
    all.skipping = Skipping::kOff;
    all.access = BufferAccess::kTexels;
    all.own_light_device = false;
    Casting some = way;
    some.access = BufferAccess::kStorage;
    const Cast plain = cast(given, scene, volume, all);
    const Cast skipping = cast(given, scene, volume, some);
    std::size_t other_depths = 0;
    for (std::size_t pixel = 0; pixel < plain.depths.cast_mm.size(); ++pixel) {
      other_depths += std::bit_cast<std::uint32_t>(plain.depths.cast_mm[pixel]) !=
                              std::bit_cast<std::uint32_t>(skipping.depths.cast_mm[pixel])
                          ? 1
                          : 0;
    }
    EXPECT_EQ(other_depths, 0U);
    EXPECT_EQ(plain.picture.rgba, skipping.picture.rgba);
    EXPECT_EQ(plain.depths.sampled_share, 1);
    return skipping.depths.sampled_share;
  }
};

TEST_P(SkippingTest, ChangesNoBit) {
  double least_share = 1;
  double sum = 0;
  for (std::uint32_t seed = GetParam(); seed < GetParam() + kCasesInABatch; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const SeededCase given = seeded_case(seed);
    const Casting way = way_of_casting(seed);
    double share = compare(given, given.scene, way);
    // A threshold above the noise: more empty space.
    Scene quiet = given.scene;
    quiet.detector.threshold = std::min(2 * quiet.detector.threshold, 250.0);
    share = std::min(share, compare(given, quiet, way));
    // Transparent grey levels in volume mode are skipped, too.
    Scene composited = quiet;
    composited.mode = Mode::kVolume;
    share = std::min(share, compare(given, composited, way));
    least_share = std::min(least_share, share);
    sum += share;
  }
  EXPECT_LT(sum / kCasesInABatch, 0.9) << "too little was passed over to prove anything";
  fmt::print("seeds {} to {}: sampled {:.2f} of the segments, {:.2f} at the least\n", GetParam(),
             GetParam() + kCasesInABatch - 1, sum / kCasesInABatch, least_share);
}

// A tile that is wide as seen from the eye: its inner rays reach farther than those at its corners.
TEST_P(SkippingTest, ChangesNoBitOfASmallPictureOfAWideView) {
  for (const std::uint32_t side : {16U, 48U}) {
    for (const int stride : {1, 2}) {
      SeededCase given = seeded_case(GetParam());
      given.size = {side, side};
      given.scene.camera.projection = Projection::kPerspective;
      given.scene.camera.opening_deg = 120;
      given.scene.rays.stride = stride;
      given.scene.mode = Mode::kSurface;
      SCOPED_TRACE(fmt::format("seed {}, side {}, stride {}", GetParam(), side, stride));
      compare(given, given.scene, way_of_casting(stride == 1 ? 0 : side / 16));
    }
  }
}

// 200 cases, three scenes each.
INSTANTIATE_TEST_SUITE_P(Seeds, SkippingTest, testing::Range(0U, 200U, kCasesInABatch));

}  // namespace
}  // namespace fanlight::test::skipping_tests
