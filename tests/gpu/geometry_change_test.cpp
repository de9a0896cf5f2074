// SPDX-License-Identifier: Apache-2.0
// A probe whose settings change while it streams: each volume is shown by its own geometry, as by a new
// renderer that was created for that geometry.
#include <algorithm>
#include <array>

#include "tests/gpu/memory_census.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::geometry_change_tests {
namespace {

constexpr PictureSize kSize{.width = 48, .height = 48};
constexpr std::uint32_t kFrameCapacity = 12;

constexpr FanGeometry kCartesian = kSmallFan;
constexpr FanGeometry kConvexLines{.kind = FrameKind::kConvexLines,
                                   .columns = 45,
                                   .rows = 60,
                                   .pixel_height_mm = 1.5,
                                   .face_column = 22,
                                   .face_row = 0,
                                   .motor_radius_mm = 30,
                                   .probe_radius_mm = 40,
                                   .line_pitch_deg = 1.5};
constexpr FanGeometry kLinearLines{.kind = FrameKind::kLinearLines,
                                   .columns = 48,
                                   .rows = 90,
                                   .pixel_width_mm = 1.5,
                                   .pixel_height_mm = 1,
                                   .face_column = 23.5,
                                   .face_row = 0,
                                   .motor_radius_mm = 30};

FanGeometry shallower() {
  FanGeometry geometry = kCartesian;
  geometry.pixel_width_mm = 1.6;
  geometry.pixel_height_mm = 1.4;
  geometry.motor_radius_mm = 25;
  return geometry;
}

FanGeometry of_another_size() {
  FanGeometry geometry = kCartesian;
  geometry.columns = 61;
  geometry.rows = 72;
  geometry.pixel_width_mm = geometry.pixel_height_mm = 1.3;
  geometry.face_column = 30;
  return geometry;
}

/// A frame wider than any texture of this GPU.
FanGeometry too_wide(const Gpu& gpu) {
  FanGeometry geometry = kCartesian;
  geometry.columns = gpu.limits().maxImageDimension3D + 1;
  geometry.rows = 2;
  return geometry;
}

/// A slanted wall: a mirrored, scaled or shifted geometry would show it elsewhere.
double wall(const Point& at) {
  return at.y_mm + 0.3 * at.x_mm + 0.2 * at.z_mm > 45 ? 160 : 5;
}

Volume volume_of(const FanGeometry& geometry, std::uint64_t id, double half_deg = 25, int frames = 11) {
  std::vector<double> angles_rad;
  for (int frame = 0; frame < frames; ++frame) {
    angles_rad.push_back(radians(half_deg * (2.0 * frame / (frames - 1) - 1)));
  }
  Volume volume = made_volume(geometry, angles_rad, wall);
  volume.stamp().volume_id = id;
  return volume;
}

class GeometryChangeTest : public GpuTest {
 protected:
  static Scene near_scene() {
    Scene scene = scene_for(kCartesian, radians(-25), radians(25), kSize.height);
    scene.camera.yaw_deg = 10;
    return scene;
  }

  static inline std::optional<Sampling> sampling;  // of all renderers of a test

  static std::unique_ptr<Renderer> renderer_for(const FanGeometry& geometry, double half_deg,
                                                const Scene& scene, RenderCounters& counters) {
    auto made = Renderer::create({.size = kSize,
                                  .geometry = geometry,
                                  .first_angle_rad = radians(-half_deg),
                                  .last_angle_rad = radians(half_deg),
                                  .frame_capacity = kFrameCapacity,
                                  .sampling = sampling},
                                 {.gpu = gpu(), .counters = counters, .store = &gpu_rig.pipelines()},
                                 {.revision = 1, .scene = scene});
    if (!made) throw std::runtime_error(made.error().message);
    return std::move(*made);
  }

  struct Shown {
    Picture picture;
    DepthMaps depths;
  };
  static Shown shown(Renderer& renderer) {
    Shown now{.picture = next_picture(renderer), .depths = {}};
    auto depths = renderer.read_depth();
    if (!depths) throw std::runtime_error(depths.error().message);
    now.depths = std::move(*depths);
    return now;
  }

  /// The picture of a renderer that was created for this volume.
  static Shown shown_afresh(const Volume& volume, const Scene& scene) {
    RenderCounters counters;
    const double half_deg = degrees(std::abs(volume.angles_rad().front()));
    const auto renderer = renderer_for(volume.geometry(), half_deg, scene, counters);
    EXPECT_TRUE(renderer->load(volume));
    return shown(*renderer);
  }

  static void expect_same(const Shown& now, const Shown& fresh, std::string_view what) {
    EXPECT_EQ(now.depths.cast_mm, fresh.depths.cast_mm) << what;
    EXPECT_EQ(now.depths.confidence, fresh.depths.confidence) << what;
    EXPECT_EQ(now.depths.smooth_mm, fresh.depths.smooth_mm) << what;
    EXPECT_EQ(now.picture.rgba, fresh.picture.rgba) << what;
    const auto hits = std::ranges::count_if(now.depths.cast_mm, [](float depth) { return depth > 0; });
    EXPECT_GT(hits, 200) << what << ": hardly a surface to compare";
  }

  /// Shows volumes of these geometries one after the other and compares each with a renderer created for it.
  void expect_each_shown_as_afresh(std::span<const FanGeometry> geometries) {
    for (const FanGeometry& geometry : geometries) {
      const Volume volume = volume_of(geometry, ++volumes_);
      ASSERT_TRUE(renderer_->load(volume));
      expect_same(shown(*renderer_), shown_afresh(volume, scene_), name_of(geometry));
    }
  }
  std::string name_of(const FanGeometry& geometry) const {
    return "volume " + std::to_string(volumes_) + ", " + std::to_string(geometry.columns) + " x " +
           std::to_string(geometry.rows);
  }

  /// Checks that the renderer still works after a refusal: the old depth map with a new light, the old volume
  /// with a new view, a new volume.
  void expect_going_on(const Volume& on_show) {
    Scene moved = scene_;
    moved.light.right_mm = 70;
    renderer_->show({.revision = 10, .scene = moved});
    expect_same(shown(*renderer_), shown_afresh(on_show, moved), "relit after a refusal");
    moved.camera.yaw_deg = -10;
    renderer_->show({.revision = 11, .scene = moved});
    expect_same(shown(*renderer_), shown_afresh(on_show, moved), "cast again after a refusal");
    const Volume next = volume_of(kConvexLines, on_show.stamp().volume_id + 1);
    ASSERT_TRUE(renderer_->load(next));
    expect_same(shown(*renderer_), shown_afresh(next, moved), "the next volume after a refusal");
  }

  const Scene scene_ = near_scene();
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_ = renderer_for(kCartesian, 25, scene_, counters_);
  std::uint64_t volumes_ = 0;
};

TEST_F(GeometryChangeTest, ShowsOtherMillimetresWithoutTakingMemory) {
  // Two volumes first, so that each slot has the memory of pass 0.
  expect_each_shown_as_afresh(std::array{kCartesian, kCartesian});
  const Volume changed[] = {volume_of(shallower(), 3), volume_of(shallower(), 4), volume_of(kCartesian, 5)};
  for (const Volume& volume : changed) {
    const MemoryCensus before = MemoryCensus::now();
    ASSERT_TRUE(renderer_->load(volume));
    next_picture(*renderer_);
    EXPECT_EQ(MemoryCensus::now(), before);
    const auto depths = renderer_->read_depth();
    EXPECT_EQ(depths->cast_mm, shown_afresh(volume, scene_).depths.cast_mm);
  }
}

TEST_F(GeometryChangeTest, ShowsOtherRowsAndColumns) {
  // The third volume is the first one in a slot that held another size.
  expect_each_shown_as_afresh(
      std::array{kCartesian, of_another_size(), of_another_size(), kCartesian, kCartesian});
}

TEST_F(GeometryChangeTest, ShowsOtherKindsOfFrames) {
  expect_each_shown_as_afresh(std::array{kCartesian, kConvexLines, kLinearLines, kConvexLines, kCartesian});
}

TEST_F(GeometryChangeTest, ShowsSweepsOfMoreAndFewerFrames) {
  std::uint64_t id = 0;
  for (const int frames : {11, 12, 5, 2, 12}) {
    const Volume volume = volume_of(kCartesian, ++id, 25, frames);
    ASSERT_TRUE(renderer_->load(volume));
    expect_same(shown(*renderer_), shown_afresh(volume, scene_), std::to_string(frames) + " frames");
  }
}

TEST_F(GeometryChangeTest, MakesRoomForMoreFramesThanUsual) {
  RenderCounters counters;
  auto roomy = Renderer::create({.size = kSize,
                                 .geometry = kCartesian,
                                 .first_angle_rad = radians(-25),
                                 .last_angle_rad = radians(25),
                                 .frame_capacity = kFrameCapacity,
                                 .usual_frames = 5},
                                {.gpu = gpu(), .counters = counters, .store = &gpu_rig.pipelines()},
                                {.revision = 1, .scene = scene_});
  ASSERT_TRUE(roomy);
  std::uint64_t id = 0;
  for (const int frames : {5, 11, static_cast<int>(kFrameCapacity), 5}) {
    const Volume volume = volume_of(kCartesian, ++id, 25, frames);
    ASSERT_TRUE((*roomy)->load(volume));
    const Shown now = shown(**roomy);
    const Shown fresh = shown_afresh(volume, scene_);
    // The texture's coordinates are divided by another number of slices: equal up to their rounding.
    std::size_t apart = 0;
    for (std::size_t at = 0; at < now.depths.cast_mm.size(); ++at) {
      if (std::abs(now.depths.cast_mm[at] - fresh.depths.cast_mm[at]) > 0.02) ++apart;
    }
    EXPECT_LE(apart, now.depths.cast_mm.size() / 1000) << frames << " frames";
  }
  EXPECT_EQ(counters.volumes_refused.value(), 0U);
  EXPECT_EQ(counters.volumes_unfiltered.value(), 0U);
}

TEST_F(GeometryChangeTest, ShowsAWiderSweepThanItWasMadeFor) {
  std::uint64_t id = 0;
  std::array<std::ptrdiff_t, 4> hits{};
  Scene scene = scene_;
  scene.camera.field_mm = 150;
  renderer_->show({.revision = 2, .scene = scene});
  for (const double half_deg : {25.0, 60.0, 40.0, 25.0}) {
    const Volume volume = volume_of(kCartesian, id + 1, half_deg);
    ASSERT_TRUE(renderer_->load(volume));
    const Shown now = shown(*renderer_);
    expect_same(now, shown_afresh(volume, scene), std::to_string(half_deg) + " deg");
    hits[id++] = std::ranges::count_if(now.depths.cast_mm, [](float depth) { return depth > 0; });
  }
  EXPECT_GT(hits[1], hits[2]);
  EXPECT_GT(hits[2], hits[3]);
  EXPECT_EQ(hits[3], hits[0]);
}

TEST_F(GeometryChangeTest, HoldsNoMoreMemoryHoweverOftenItChanges) {
  // Each geometry twice, since the two slots alternate.
  const std::array geometries = {kCartesian, of_another_size(), kConvexLines};
  std::array<MemoryCensus, 3> first{};
  for (std::size_t change = 0; change < 21; ++change) {
    for (int slot = 0; slot < 2; ++slot) {
      ASSERT_TRUE(renderer_->load(volume_of(geometries[change % 3], ++volumes_)));
      next_picture(*renderer_);
    }
    const MemoryCensus now = MemoryCensus::now();
    if (change < 3) first[change] = now;
    EXPECT_EQ(now.held, first[change % 3].held) << "change " << change;
    EXPECT_EQ(now.held_bytes, first[change % 3].held_bytes) << "change " << change;
  }
  EXPECT_EQ(counters_.volumes_rendered.value(), 42U);
}

TEST_F(GeometryChangeTest, RelightsTheVolumeOnShowWhileOneOfAnotherGeometryIsCast) {
  const Volume shown_first = volume_of(kCartesian, 1);
  const Volume cast_meanwhile = volume_of(kConvexLines, 2);
  ASSERT_TRUE(renderer_->load(shown_first));
  next_picture(*renderer_);
  ASSERT_TRUE(renderer_->load(cast_meanwhile));
  Scene moved = scene_;
  moved.light.right_mm = 70;
  renderer_->show({.revision = 2, .scene = moved});
  const Picture relit = next_picture(*renderer_);
  EXPECT_EQ(relit.stamp.volume.volume_id, 1U);
  EXPECT_EQ(relit.stamp.scene_revision, 2U);
  EXPECT_EQ(relit.rgba, shown_afresh(shown_first, moved).picture.rgba);
  expect_same(shown(*renderer_), shown_afresh(cast_meanwhile, moved), "the volume that was cast meanwhile");
}

/// Textures have their own limits, which also apply on a processor that uses Sampling::kGathering by default.
class TextureLimitTest : public GeometryChangeTest {
 protected:
  void SetUp() override {
    sampling = Sampling::kTexture;
    renderer_ = renderer_for(kCartesian, 25, scene_, counters_);
  }
  void TearDown() override {
    sampling.reset();
    GeometryChangeTest::TearDown();
  }
};

TEST_F(TextureLimitTest, RefusesAVolumeBeyondTheLimitsOfTheGpuAndGoesOn) {
  const Volume on_show = volume_of(of_another_size(), 1);
  ASSERT_TRUE(renderer_->load(on_show));
  next_picture(*renderer_);
  for (std::uint64_t refused = 1; refused <= 2; ++refused) {
    const auto loaded = renderer_->load(volume_of(too_wide(gpu()), 1 + refused));
    ASSERT_FALSE(loaded);
    EXPECT_EQ(loaded.error().code, ErrorCode::kUnsupported) << loaded.error().message;
    EXPECT_EQ(counters_.volumes_refused.value(), refused);
    EXPECT_FALSE(renderer_->busy());
  }
  expect_going_on(on_show);
  EXPECT_EQ(counters_.volumes_rendered.value(), 2U);
  EXPECT_EQ(counters_.volumes_skipped.value(), 0U);
}

TEST_F(TextureLimitTest, RefusesAVolumeThatWouldReplaceTheOneOnShowBeforeTheNextIsDone) {
  ASSERT_TRUE(renderer_->load(volume_of(kCartesian, 1)));
  next_picture(*renderer_);
  const Volume next = volume_of(of_another_size(), 2);
  ASSERT_TRUE(renderer_->load(next));
  while (!renderer_->wants_volume()) {
    ASSERT_TRUE(renderer_->advance());
    ASSERT_TRUE(renderer_->wait(1'000'000'000));
  }
  // The next volume is being lit. The refused volume would take the slot of the shown one.
  ASSERT_FALSE(renderer_->load(volume_of(too_wide(gpu()), 3)));
  Scene moved = scene_;
  moved.light.right_mm = -70;
  renderer_->show({.revision = 2, .scene = moved});
  Picture picture;
  while (picture.stamp.volume.volume_id < 2 || picture.stamp.scene_revision < 2) {
    picture = next_picture(*renderer_);
  }
  EXPECT_EQ(picture.rgba, shown_afresh(next, moved).picture.rgba);
  EXPECT_EQ(counters_.volumes_refused.value(), 1U);
  expect_going_on(next);
}

TEST_F(GeometryChangeTest, RefusesAVolumeThatTheGpuHasNoMemoryFor) {
  const std::uint32_t most = gpu().limits().maxImageDimension3D;
  FanGeometry tiny = kCartesian;
  tiny.columns = tiny.rows = 4;
  FanGeometry huge = kCartesian;
  huge.columns = huge.rows = std::min(most, 4096U);
  auto made = Renderer::create({.size = kSize,
                                .geometry = tiny,
                                .first_angle_rad = radians(-25),
                                .last_angle_rad = radians(25),
                                .frame_capacity = most},
                               {.gpu = gpu(), .counters = counters_, .store = &gpu_rig.pipelines()},
                               {.revision = 1, .scene = scene_});
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_TRUE((*made)->load(volume_of(tiny, 1)));
  const Picture before = next_picture(**made);
  const MemoryCensus census = MemoryCensus::now();
  // 3.4 GB on lavapipe, whose limit is 2 GB. The pixels are never written, so the volume uses no memory here.
  constexpr std::uint32_t kFrames = 200;
  Volume volume(huge, kFrames);
  for (std::uint32_t frame = 0; frame < kFrames; ++frame)
    volume.add_frame({.sequence = frame, .angle_rad = 0.001 * frame});
  volume.sort_by_angle();
  volume.stamp().volume_id = 2;
  const auto loaded = (*made)->load(volume);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kUnavailable) << loaded.error().message;
  EXPECT_EQ(counters_.volumes_refused.value(), 1U);
  EXPECT_LT(MemoryCensus::now().held, census.held) << "what its slot held before is given back";
  ASSERT_TRUE((*made)->load(volume_of(tiny, 3)));
  EXPECT_EQ(next_picture(**made).rgba, before.rgba);
}

}  // namespace
}  // namespace fanlight::test::geometry_change_tests
