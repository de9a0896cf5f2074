// SPDX-License-Identifier: Apache-2.0
// Runs the acquisition and the render thread, hot from the end of their first second. If our code allocates,
// locks or logs on one of them, the process aborts and prints the stack.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "acquisition/phantom/phantom_source.hpp"
#include "acquisition/replay/replay_source.hpp"
#include "acquisition/source/pacer.hpp"
#include "proto/base/clock.hpp"
#include "tests/hot_path/pipeline_fixture.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr std::int64_t kColdNs = 1'000'000'000;
constexpr std::uint64_t kVolumes = 120;
constexpr std::uint64_t kPicturesOfAScene = 8;

/// Scenes that together run every shader. When one is shown for the first time, its pipelines are built and
/// pass 0 allocates its memory. Between two scenes the renderer shows the old view in the new light, so each
/// projection has to occur here with each kind of shadow.
std::vector<Scene> tour(const Scene& first) {
  std::vector<Scene> scenes(4, first);
  scenes[1].camera.projection = Projection::kPerspective;
  scenes[1].shadow.softness_mm = 0;
  scenes[1].filter.kind = DepthFilter::kEdgePreserving;
  scenes[2].camera.projection = Projection::kPerspective;
  scenes[2].mode = Mode::kSlices;
  scenes[2].speckle = {.filter = SpeckleFilter::kMedian, .size = 3};
  scenes[2].finish.smoothing = Smoothing::kDiffusion;
  scenes[3].shadow.softness_mm = 0;
  scenes[3].mode = Mode::kSurfaceAndVolume;
  scenes[3].speckle = {.filter = SpeckleFilter::kBox, .size = 3};
  scenes[3].filter.kind = DepthFilter::kMean;
  scenes[3].filter.weights = FilterWeights::kConfidence;
  scenes[3].filter.steady = 0.3;
  return scenes;
}

/// The scene after the n-th change of the fields that an operator changes often.
Scene moved(Scene scene, std::uint64_t n) {
  scene.light.right_mm = -90 + static_cast<double>(n % 180);
  scene.light.ambient = 0.1 + 0.05 * static_cast<double>(n % 5);
  if (n % 2 == 0) scene.camera.yaw_deg = static_cast<double>(n % 40);
  if (n % 3 == 0) scene.detector.threshold = 15 + static_cast<double>(n % 10);
  if (n % 5 == 0) {
    scene.filter.size_mm = 0;
    scene.filter.size = 9 + 2 * static_cast<int>(n % 7);
    scene.filter.islands = 1 + 2 * static_cast<int>(n % 4);
    scene.filter.holes = 1 + 2 * static_cast<int>(n % 4);
  }
  return scene;
}

/// Shows a scene until both slots of the renderer have rendered it. They take volumes alternately.
void show_in_both_slots(PipelineFixture& fixture, const Scene& scene) {
  const std::uint64_t revision = fixture.show(scene);
  const Picture* picture = &fixture.next_picture();
  while (picture->stamp.scene_revision < revision) picture = &fixture.next_picture();
  const std::uint64_t volume = picture->stamp.volume.volume_id;
  while (picture->stamp.volume.volume_id == volume) picture = &fixture.next_picture();
}

/// Takes the first second, or longer if the pipelines are built later.
void warm_up(PipelineFixture& fixture, const std::vector<Scene>& scenes) {
  for (const Scene& scene : scenes) show_in_both_slots(fixture, scene);
  while (now_ns() - fixture.started_ns() < kColdNs) fixture.next_picture();
}

void expect_quiet_hot_path(FrameSource& source, RingPolicy policy,
                           const std::filesystem::path& recordings = {}) {
  PipelineFixture fixture(source, policy, recordings);
  const std::vector<Scene> scenes = tour(fixture.suggested());
  warm_up(fixture, scenes);
  fixture.make_hot();
  const std::int64_t hot_since_ns = now_ns();
  const std::uint64_t volumes_before = fixture.counters().volumes_rendered.value();
  const std::uint64_t driver_before = calls_within_driver();
  std::uint64_t pictures = 0;
  while (fixture.counters().volumes_rendered.value() < volumes_before + kVolumes) {
    fixture.next_picture();
    ++pictures;
    fixture.show(moved(scenes[pictures / kPicturesOfAScene % scenes.size()], pictures));
  }
  EXPECT_GT(pictures, kPicturesOfAScene * scenes.size()) << "not every scene was shown";
  const std::uint64_t driver_calls = calls_within_driver() - driver_before;
  EXPECT_GT(driver_calls, 0U)
      << "no driver does without: the hook did not show_in_both_slots the render thread";
  fmt::print("hot after {:.1f} s, for {:.1f} s: {} volumes, {} pictures, {} calls within the driver\n",
             static_cast<double>(hot_since_ns - fixture.started_ns()) / 1e9,
             static_cast<double>(now_ns() - hot_since_ns) / 1e9, kVolumes, pictures, driver_calls);
}

constexpr PhantomSource::Config kLive{
    .frame_rate_hz = 500, .frames_per_volume = 16, .columns = 64, .rows = 64};

/// A source that allocates for each frame. It is slow, so that the hook finds it before the renderer has a
/// volume.
class WastefulSource final : public FrameSource {
 public:
  const SourceDescription& description() const override { return probe_->description(); }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override {
    return probe_->next_frame(std::move(stop));
  }
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override {
    std::free(std::malloc(pixels.size()));
    return probe_->read_pixels(pixels, std::move(stop));
  }

 private:
  std::unique_ptr<PhantomSource> probe_ =
      PhantomSource::create({.frame_rate_hz = 20, .frames_per_volume = 16, .columns = 64, .rows = 64})
          .value();
};

/// Shows scenes whose pipelines and memory the renderer does not have yet.
void run_hot_from_the_start(FrameSource& source) {
  PipelineFixture fixture(source, RingPolicy::kNewestWins);
  fixture.make_hot();
  for (const Scene& scene : tour(fixture.suggested())) show_in_both_slots(fixture, scene);
}

TEST(HotPathDeathTest, IsWatchedOnTheAcquisitionThread) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  WastefulSource source;
  // The thread becomes hot at any instant, also between the two calls.
  EXPECT_DEATH(
      run_hot_from_the_start(source),
      "hot path: (malloc|free) on the hot thread [0-9]+ ..acquisition...*fanlight::AcquisitionThread");
}

TEST(HotPathDeathTest, IsWatchedOnTheRenderThread) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  auto source = PhantomSource::create(kLive);
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_DEATH(run_hot_from_the_start(**source), "hot path: .*fanlight::Render");
}

// The start ends after the first second, also if no volume has arrived by then: everything that the first
// scene needs must be allocated when the renderer is created.
TEST(HotPathTest, IsQuietAfterTheFirstSecondOfASlowProbe) {
  auto source =
      PhantomSource::create({.frame_rate_hz = 12, .frames_per_volume = 16, .columns = 64, .rows = 64});
  ASSERT_TRUE(source) << source.error().message;
  PipelineFixture fixture(**source, RingPolicy::kNewestWins);
  Pacer().wait_until(fixture.started_ns() + kColdNs, {});
  fixture.make_hot();
  // The third volume uses the slot of the first one again.
  while (fixture.next_picture().stamp.volume.volume_id < 3) {
  }
}

TEST(HotPathTest, IsQuietWhereVolumesComeLive) {
  auto source = PhantomSource::create(kLive);
  ASSERT_TRUE(source) << source.error().message;
  expect_quiet_hot_path(**source, RingPolicy::kNewestWins);
}

TEST(HotPathTest, IsQuietWhereFramesReplaceThoseOfTheLastSweep) {
  auto source =
      PhantomSource::create({.frame_rate_hz = 60, .frames_per_volume = 16, .columns = 64, .rows = 64});
  ASSERT_TRUE(source) << source.error().message;
  PipelineFixture fixture(**source, RingPolicy::kNewestWins);
  Scene scene = fixture.suggested();
  scene.refresh = Refresh::kFrame;
  warm_up(fixture, {scene});
  fixture.make_hot();
  bool blends = false;
  for (std::uint64_t pictures = 0; pictures < 100; ++pictures) {
    blends |= fixture.next_picture().stamp.seam_frames > 0;
    scene.light.right_mm = static_cast<double>(pictures);
    if (pictures % 10 == 0) fixture.show(scene);
  }
  EXPECT_TRUE(blends);
}

TEST(HotPathTest, IsQuietWhileFramesAreRecorded) {
  const TemporaryFolder folder;
  auto source = PhantomSource::create(kLive);
  ASSERT_TRUE(source) << source.error().message;
  expect_quiet_hot_path(**source, RingPolicy::kNewestWins, folder.path());
  // One file, or on a busy machine what `fanlight recover` makes one of.
  std::uint64_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) bytes += entry.file_size();
  EXPECT_GT(bytes, 16U * 64 * 64 * kVolumes);
}

TEST(HotPathTest, IsQuietWhereEveryVolumeIsRendered) {
  auto source = PhantomSource::create({.frames_per_volume = 16,
                                       .columns = 64,
                                       .rows = 64,
                                       .lag_deg = 1,
                                       .jitter_deg = 0.1,
                                       .turning_frames = 2,
                                       .index = PhantomSource::Index::kOff,
                                       .lost_percent = 1,
                                       .pace = PhantomSource::Pace::kUnpaced});
  ASSERT_TRUE(source) << source.error().message;
  expect_quiet_hot_path(**source, RingPolicy::kProcessAll);
}

TEST(HotPathTest, IsQuietWhereARecordingIsSweptToAndFro) {
  const TemporaryFolder folder;
  write_file(folder / "sweep.igs.mha", fan_recording(16, 4, 30).bytes());
  auto source = ReplaySource::create({.recording = {.path = folder / "sweep.igs.mha", .geometry_path = {}},
                                      .pace = ReplaySource::Pace::kAsFastAsTaken,
                                      .ending = ReplaySource::Ending::kToAndFro});
  ASSERT_TRUE(source) << source.error().message;
  expect_quiet_hot_path(**source, RingPolicy::kProcessAll);
}

}  // namespace
}  // namespace fanlight::test
