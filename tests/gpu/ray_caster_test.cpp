// SPDX-License-Identifier: Apache-2.0
// Rays that the processor casts (renderer/rays) against those of the shader, and its instruction sets against
// each other.
#include "renderer/rays/ray_caster.hpp"

#include <fmt/format.h>
#include <hwy/targets.h>

#include <bit>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "tests/gpu/seeded_case.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::ray_caster_tests {
namespace {

constexpr std::uint32_t kCasesInABatch = 10;
constexpr std::uint32_t kBatches = 8;

struct Cast {
  DepthMaps depths;
  Picture picture;
};

class RayCasterTest : public GpuTest, public testing::WithParamInterface<std::uint32_t> {
 protected:
  void SetUp() override {
    if (gpu().candidate().kind != kProcessorKind) GTEST_SKIP() << "this GPU casts the rays itself";
  }

  static Cast cast(const SeededCase& given, const Volume& volume, const Scene& scene, bool by_shader) {
    RenderCounters counters;
    const auto renderer = made_renderer(given.geometry, given.angles_rad, given.size, scene, counters,
                                        {.sampling = Sampling::kGathering, .rays_by_shader = by_shader});
    if (auto loaded = renderer->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    Cast made{.depths = {}, .picture = next_picture(*renderer)};
    made.depths = *renderer->read_depth();
    return made;
  }

  static SeededCase case_of(std::uint32_t seed) {
    SeededCase given = seeded_case(seed);
    // The picture of this volume alone.
    given.scene.filter.steady = 0;
    return given;
  }
};

struct Differences {
  std::size_t pixels = 0;
  std::size_t surfaces = 0;
  std::size_t moved = 0;     // by more than a hundredth of a millimetre, or there in one of them alone
  std::size_t coloured = 0;  // by more than two levels

  void add(const Cast& here, const Cast& by_shader) {
    for (std::size_t pixel = 0; pixel < here.depths.cast_mm.size(); ++pixel) {
      const float a = here.depths.cast_mm[pixel];
      const float b = by_shader.depths.cast_mm[pixel];
      ++pixels;
      surfaces += a >= 0 ? 1U : 0U;
      moved += (a >= 0) != (b >= 0) || std::abs(a - b) > 0.01F ? 1U : 0U;
      for (std::size_t byte = 4 * pixel; byte < 4 * pixel + 3; ++byte) {
        if (std::abs(here.picture.rgba[byte] - by_shader.picture.rgba[byte]) <= 2) continue;
        ++coloured;
        break;
      }
    }
  }
};

TEST_P(RayCasterTest, FindTheSurfacesAndColoursOfTheShader) {
  if (!ray_caster::is_fast()) GTEST_SKIP() << "this processor gathers no words: the shader casts the rays";
  Differences differences;
  for (std::uint32_t seed = kCasesInABatch * GetParam(); seed < kCasesInABatch * (GetParam() + 1); ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const SeededCase given = case_of(seed);
    const Volume volume = made_volume(given.geometry, given.angles_rad, given.grey);
    for (const Mode mode : {given.scene.mode, Mode::kVolume, Mode::kMaximum}) {
      Scene scene = given.scene;
      scene.mode = mode;
      const Cast here = cast(given, volume, scene, false);
      const Cast by_shader = cast(given, volume, scene, true);
      differences.add(here, by_shader);
      // Rounding may decide on a segment whose levels are at the threshold.
      EXPECT_NEAR(here.depths.sampled_share, by_shader.depths.sampled_share, 2e-3);
    }
  }
  fmt::print("{} of {} pixels have a surface, {} moved, {} have another colour\n", differences.surfaces,
             differences.pixels, differences.moved, differences.coloured);
  EXPECT_GT(differences.surfaces, 10'000U) << "too little was seen to prove anything";
  EXPECT_LE(differences.moved, differences.surfaces / 2000);
  EXPECT_LE(differences.coloured, differences.pixels / 2000);
}

TEST_P(RayCasterTest, GivesTheSameBitsOnEachInstructionSet) {
  if (!ray_caster::is_fast()) GTEST_SKIP() << "this processor gathers no words: the shader casts the rays";
  const SeededCase given = case_of(kCasesInABatch * GetParam());
  const Volume volume = made_volume(given.geometry, given.angles_rad, given.grey);
  const auto bits = [&] {
    const Cast made = cast(given, volume, given.scene, false);
    std::vector<std::uint32_t> of_depths;
    for (const float depth : made.depths.cast_mm) of_depths.push_back(std::bit_cast<std::uint32_t>(depth));
    return std::pair(of_depths, made.picture.rgba);
  };
  const auto chosen = bits();
  int compared = 0;
  // Renderers ask for AVX2 at least: others cannot be chosen by them.
  for (const auto target : {HWY_AVX2, HWY_AVX3}) {
    if ((hwy::SupportedTargets() & target) == 0) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    EXPECT_TRUE(bits() == chosen) << hwy::TargetName(target);
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
    ++compared;
  }
  EXPECT_GE(compared, 1);
}

// A ray may find many edges before its neighbours find one.
TEST_P(RayCasterTest, PlaceManyEdgesOfOneRayInTheirOrder) {
  if (!ray_caster::is_fast()) GTEST_SKIP() << "this processor gathers no words: the shader casts the rays";
  SeededCase given = case_of(kCasesInABatch * GetParam());
  Scene& scene = given.scene;
  scene.mode = Mode::kSurface;
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.detector.window = 2;
  scene.detector.threshold = 2;
  scene.detector.place = SurfacePlace::kFirstCrossing;
  scene.detector.sign = EdgeSign::kEither;
  scene.detector.least_contrast = 0;
  scene.glass.amount = GetParam() % 2;
  // Many layers in some rays, and nothing but the last surface in their neighbours.
  const Volume volume = made_volume(given.geometry, given.angles_rad, [](const Point& at) {
    const bool has_layers = std::fmod(std::abs(at.x_mm), 4.0) < 2.0;
    const double layers = std::fmod(std::abs(at.y_mm), 3.0) < 1.5 ? 120 : 20;
    return at.y_mm > 45 ? 250.0 : has_layers ? layers : 0.0;
  });
  Differences differences;
  differences.add(cast(given, volume, scene, false), cast(given, volume, scene, true));
  EXPECT_LE(differences.moved, differences.surfaces / 500);
  EXPECT_LE(differences.coloured, differences.pixels / 500);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RayCasterTest, testing::Range(0U, kBatches));

}  // namespace
}  // namespace fanlight::test::ray_caster_tests
