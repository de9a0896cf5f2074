// SPDX-License-Identifier: Apache-2.0
// A GPU that is lost, hangs, or has no memory: the render thread continues, or says why it does not.
#include <algorithm>

#include "renderer/render_once.hpp"
#include "tests/gpu/faulty_pipeline.hpp"
#include "tests/support/gpu_rig.hpp"

namespace fanlight::test::gpu_fault_tests {
namespace {

using State = RenderHealth::State;

constexpr double kNearMm = 40;
constexpr double kFarMm = 60;
constexpr std::uint64_t kAlways = 1'000'000'000;

class GpuFaultTest : public FaultyPipeline {
 protected:
  /// What the two plates look like without a fault.
  void SetUp() override {
    start();
    // After the first picture of each slot the number of its submissions stays the same.
    for (int pictures = 0; pictures < 2; ++pictures) {
      near_ = picture_of(publish(kNearMm));
      far_ = picture_of(publish(kFarMm));
    }
    near_ = picture_of(publish(kNearMm));
    const std::uint64_t before = gpu_calls(GpuCall::kSubmit);
    far_ = picture_of(publish(kFarMm));
    submissions_ = gpu_calls(GpuCall::kSubmit) - before;
    ASSERT_NE(near_.rgba, far_.rgba);
    ASSERT_GE(submissions_, 1U);
    ASSERT_EQ(counters_.devices_lost.value(), 0U);
  }
  /// A volume of the near plate comes, and its picture is right.
  void expect_next_volume() {
    const Picture next = picture_of(publish(kNearMm));
    EXPECT_EQ(next.rgba, near_.rgba);
    EXPECT_EQ(next.depth_mm, near_.depth_mm);
    EXPECT_FALSE(failure_);
  }
  /// The GPU is lost at the first submission of a volume, and then at the last one.
  void expect_losses_to_cost_the_device_only();
  /// Each submission of a volume in turn finds no memory three times.
  void expect_lacks_of_memory_to_cost_time_only();

  /// Ends the thread, so that nothing is in flight any more.
  void end() {
    ASSERT_TRUE(eventually([this] { return thread_->end(kLongestNs); }));
    read_others();
    expect_sums();
  }

  Picture near_;
  Picture far_;
  std::uint64_t submissions_ = 0;  // of a volume
};

/// Where passes 0 and 1 are the GPU's: with a texture they are, on a processor too.
class GpuShaderFaultTest : public GpuFaultTest {
 protected:
  GpuShaderFaultTest() { sampling_ = Sampling::kTexture; }
};

void GpuFaultTest::expect_losses_to_cost_the_device_only() {
  // Two losses, so that the GPU is not given up.
  const std::uint64_t passes[] = {0, submissions_ - 1};
  std::uint64_t lost = 0;
  for (const std::uint64_t after : passes) {
    inject({.call = GpuCall::kSubmit, .after = after});
    const Picture next = picture_of(publish(kNearMm));
    EXPECT_EQ(next.rgba, near_.rgba) << "lost after " << after << " submissions";
    EXPECT_EQ(counters_.devices_lost.value(), ++lost);
  }
  EXPECT_TRUE(eventually([this] {
    read_others();
    return !seen_.empty() && seen_.back().state == State::kRunning && seen_.back().devices_lost == 2;
  }));
  EXPECT_TRUE(saw(State::kRemaking));
  expect_next_volume();
  // On a processor passes 2 and 3 are several submissions, the last of which is lost.
  EXPECT_LE(counters_.pictures_lost.value(), 1U);
  EXPECT_EQ(counters_.volumes_skipped.value(), 2U);
  end();
}

// What follows the rays is the one submission of a processor; with shaders all passes are submitted.
TEST_F(GpuFaultTest, ALossAtASubmissionOfAVolumeCostsThatDeviceOnly) {
  expect_losses_to_cost_the_device_only();
}
TEST_F(GpuShaderFaultTest, ALossAtAnySubmissionOfAVolumeCostsThatDeviceOnly) {
  ASSERT_GE(submissions_, 2U);
  expect_losses_to_cost_the_device_only();
}

TEST_F(GpuFaultTest, ALossWhileAPictureIsReadBackShowsNoOldMemory) {
  // Of the many looks at the counter of a volume, one early and one late.
  for (const std::uint64_t after : {3U, 40U}) {
    const std::uint64_t before = gpu_faults_so_far();
    inject({.call = GpuCall::kSemaphoreValue, .after = after});
    // The counter may not be looked at so often for one picture.
    while (gpu_faults_so_far() == before && !HasFailure()) {
      EXPECT_EQ(picture_of(publish(kNearMm)).rgba, near_.rgba);
      EXPECT_EQ(picture_of(publish(kFarMm)).rgba, far_.rgba);
    }
  }
  EXPECT_EQ(counters_.devices_lost.value(), 2U);
  expect_next_volume();
  end();
}

// A processor submits nothing for a moved light.
TEST_F(GpuShaderFaultTest, TheLastVolumeIsShownAgainWhereNoOtherComes) {
  inject({.call = GpuCall::kSubmit});
  Scene moved = scene_;
  moved.light.right_mm = 60;
  show(2, moved);
  const Picture relit = picture_of(volumes_);
  EXPECT_EQ(counters_.devices_lost.value(), 1U);
  EXPECT_EQ(relit.stamp.scene_revision, 2U);
  EXPECT_EQ(relit.stamp.volume.volume_id, volumes_);
  EXPECT_EQ(relit.depth_mm, far_.depth_mm);
  EXPECT_NE(relit.rgba, far_.rgba);
  EXPECT_EQ(counters_.volumes_rendered.value(), volumes_) << "each was counted once";
  end();
}

TEST_F(GpuFaultTest, AThirdLossInAMinuteEndsTheThreadAndSaysSo) {
  inject({.call = GpuCall::kSubmit, .times = kAlways});
  publish(kNearMm);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return failure_.has_value();
  }));
  ASSERT_TRUE(failure_);
  EXPECT_EQ(failure_->code, ErrorCode::kLost);
  EXPECT_NE(failure_->message.find("3 times"), std::string::npos) << failure_->message;
  EXPECT_NE(failure_->message.find("VK_ERROR_DEVICE_LOST"), std::string::npos) << failure_->message;
  EXPECT_EQ(counters_.devices_lost.value(), 3U);
  end();
}

TEST_F(GpuFaultTest, ADeviceThatCannotBeOpenedAtOnceIsTriedAgain) {
  inject({.call = GpuCall::kCreateDevice, .times = 2, .result = VK_ERROR_INITIALIZATION_FAILED});
  inject({.call = GpuCall::kSubmit});
  expect_next_volume();
  EXPECT_EQ(counters_.devices_lost.value(), 1U);
  end();
}

void GpuFaultTest::expect_lacks_of_memory_to_cost_time_only() {
  for (std::uint64_t after = 0; after < submissions_; ++after) {
    const std::uint64_t before = gpu_faults_so_far();
    inject({.call = GpuCall::kSubmit, .after = after, .times = 3, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
    expect_next_volume();
    EXPECT_EQ(gpu_faults_so_far(), before + 3);
  }
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  end();
}

TEST_F(GpuFaultTest, AShortLackOfMemoryForASubmissionCostsTimeOnly) {
  expect_lacks_of_memory_to_cost_time_only();
}
TEST_F(GpuShaderFaultTest, AShortLackOfMemoryForASubmissionCostsTimeOnly) {
  expect_lacks_of_memory_to_cost_time_only();
}

TEST_F(GpuFaultTest, ALongLackOfMemoryForASubmissionCostsTheDevice) {
  inject({.call = GpuCall::kSubmit, .times = kAlways, .result = VK_ERROR_OUT_OF_HOST_MEMORY});
  publish(kNearMm);
  EXPECT_TRUE(eventually([this] { return counters_.devices_lost.value() > 0; }));
  clear_gpu_faults();
  expect_next_volume();
  end();
}

TEST_F(GpuFaultTest, AVolumeWithoutMemoryIsRefusedWithTheReasonAndTheNextIsShown) {
  inject({.call = GpuCall::kAllocateMemory, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  publish(kNearMm, kDeeper);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return !seen_.empty() &&
           seen_.back().volume_refusal.view().find("VK_ERROR_OUT_OF_DEVICE_MEMORY") != std::string::npos;
  }));
  EXPECT_EQ(counters_.volumes_refused.value(), 1U);
  const std::uint64_t volume = publish(kNearMm, kDeeper);
  EXPECT_EQ(picture_of(volume).stamp.volume.volume_id, volume);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return seen_.back().volume_refusal.empty();
  }));
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  expect_next_volume();
  end();
}

TEST_F(GpuFaultTest, VolumesThatHadRoomAndHaveItNoMoreCostTheDeviceOnce) {
  picture_of(publish(kNearMm, kDeeper));
  picture_of(publish(kNearMm, kDeeper));
  inject({.call = GpuCall::kAllocateMemory, .times = kAlways, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  // Each needs memory of its own, since the size differs from the last one's.
  EXPECT_TRUE(eventually([this] {
    const std::uint64_t taken = ring_.counters().volumes_taken.value();
    if (taken == volumes_) publish(kNearMm);
    return counters_.devices_lost.value() > 0;
  }));
  EXPECT_GE(counters_.volumes_refused.value(), 3U);
  clear_gpu_faults();
  expect_next_volume();
  EXPECT_EQ(counters_.devices_lost.value(), 1U);
  end();
}

TEST_F(GpuShaderFaultTest, AModeWithoutMemoryKeepsTheViewAndIsShownLater) {
  Scene other = scene_;
  other.mode = Mode::kMean;
  inject({.call = GpuCall::kBuildPipeline, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  show(2, other);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return !seen_.empty() && seen_.back().refused_revision == 2;
  }));
  const Picture kept = picture_of(publish(kNearMm));
  // The scene is tried again, but not at once; also where no further volume comes.
  Picture later = kept;
  while (later.stamp.scene_revision < 2 && !HasFailure()) later = picture_of(volumes_);
  EXPECT_NE(later.rgba, near_.rgba);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return seen_.back().refused_revision == 0;
  }));
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  EXPECT_FALSE(failure_);
  end();
}

TEST_F(GpuShaderFaultTest, APipelineThatIsNeverBuiltKeepsTheView) {
  Scene other = scene_;
  other.mode = Mode::kMaximum;
  inject({.call = GpuCall::kBuildPipeline, .times = kAlways, .result = VK_ERROR_UNKNOWN});
  show(2, other);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return !seen_.empty() && !seen_.back().scene_refusal.empty();
  }));
  for (int volume = 0; volume < 5; ++volume) {
    const Picture next = picture_of(publish(kNearMm));
    EXPECT_EQ(next.stamp.scene_revision, 1U);
    EXPECT_EQ(next.rgba, near_.rgba);
  }
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  end();
}

/// A change of a scene, for which the driver builds a pipeline of one kind of pass.
struct PassChange {
  const char* pass;
  void (*change)(Scene& scene);
};
const PassChange kPassChanges[] = {
    {"pass 0", [](Scene& scene) { scene.speckle.filter = SpeckleFilter::kMedian; }},
    {"pass 1", [](Scene& scene) { scene.mode = Mode::kMean; }},
};
// Those of passes 2 and 3 are all built with the renderer.
const PassChange kReadyChanges[] = {
    {"pass 2", [](Scene& scene) { scene.filter.kind = DepthFilter::kMean; }},
    {"pass 3", [](Scene& scene) { scene.finish.smoothing = Smoothing::kDiffusion; }},
};

TEST_F(GpuFaultTest, ChangesOfPasses2And3NeedNoPipeline) {
  inject({.call = GpuCall::kBuildPipeline, .times = kAlways, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  const std::uint64_t before = gpu_faults_so_far();
  std::uint64_t revision = 1;
  for (const PassChange& each : kReadyChanges) {
    Scene changed = scene_;
    each.change(changed);
    show(++revision, changed);
    Picture shown = picture_of(volumes_);
    while (shown.stamp.scene_revision < revision && !HasFailure()) shown = picture_of(volumes_);
    EXPECT_EQ(shown.stamp.scene_revision, revision) << each.pass;
  }
  EXPECT_EQ(gpu_faults_so_far(), before);
  end();
}

TEST_F(GpuShaderFaultTest, AChangeThatCannotBeDrawnIsReportedWhicheverPassItIsOf) {
  std::uint64_t revision = 1;
  for (const PassChange& each : kPassChanges) {
    Scene changed = scene_;
    each.change(changed);
    inject({.call = GpuCall::kBuildPipeline, .times = kAlways, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
    const std::uint64_t before = gpu_faults_so_far();
    show(++revision, changed);
    EXPECT_TRUE(eventually([&] {
      read_others();
      return !seen_.empty() && seen_.back().refused_revision == revision;
    })) << each.pass;
    EXPECT_GT(gpu_faults_so_far(), before) << each.pass;
    EXPECT_EQ(picture_of(publish(kNearMm)).rgba, near_.rgba) << each.pass << ": the view before stays";
    clear_gpu_faults();
    show(++revision, scene_);  // as the server withdraws it
    EXPECT_TRUE(eventually([&] {
      read_others();
      return seen_.back().refused_revision == 0;
    })) << each.pass;
  }
  expect_next_volume();  // so that nothing is in flight
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  end();
}

TEST_F(GpuShaderFaultTest, TheLightOfAnOlderCastDoesNotProveANewView) {
  // The view changes while a volume is cast or lit: its light comes after the change.
  Scene other = scene_;
  other.mode = Mode::kMinimum;
  inject({.call = GpuCall::kBuildPipeline, .times = kAlways, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  std::uint64_t revision = 1;
  for (int round = 0; round < 12; ++round) {
    const std::uint64_t before = gpu_calls(GpuCall::kSubmit);
    const std::uint64_t volume = publish(round % 2 == 0 ? kNearMm : kFarMm);
    EXPECT_TRUE(eventually(
        [&] { return gpu_calls(GpuCall::kSubmit) >= before + static_cast<std::uint64_t>(round) / 2; }));
    show(++revision, other);
    EXPECT_TRUE(eventually([&] {
      read_others();
      return !seen_.empty() && seen_.back().refused_revision == revision;
    }));
    EXPECT_EQ(picture_of(volume).rgba, (round % 2 == 0 ? near_ : far_).rgba);
    show(++revision, scene_);
  }
  expect_next_volume();  // so that nothing is in flight
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  end();
}

TEST_F(GpuShaderFaultTest, AFilterWithoutMemoryIsLeftOutOfThatVolumeOnly) {
  Scene filtered = scene_;
  filtered.speckle.across += 2;  // it needs more memory for its coefficients
  inject({.call = GpuCall::kAllocateMemory, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  show(2, filtered);
  EXPECT_TRUE(eventually([this] { return counters_.volumes_unfiltered.value() == 1; }));
  EXPECT_TRUE(eventually([this] {
    read_others();
    return !seen_.empty() && seen_.back().filter_left_out;
  }));
  // Each slot of the renderer has memory of its own.
  for (int volume = 0; volume < 4; ++volume) EXPECT_EQ(picture_of(publish(kNearMm)).stamp.scene_revision, 2U);
  EXPECT_EQ(counters_.volumes_unfiltered.value(), 1U);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return !seen_.back().filter_left_out;
  }));
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
  end();
}

class GpuHangTest : public FaultyPipeline {};

TEST_F(GpuHangTest, IsFoundAndCostsTheDevice) {
  start(impatient());
  const Picture near = picture_of(publish(kNearMm));
  inject({.call = GpuCall::kSubmit, .hangs = true});
  const Picture far = picture_of(publish(kFarMm));
  EXPECT_NE(far.rgba, near.rgba);
  EXPECT_EQ(counters_.devices_lost.value(), 1U);
  const auto hung = std::ranges::find(seen_, State::kRemaking, &RenderHealth::state);
  ASSERT_NE(hung, seen_.end());
  EXPECT_NE(hung->cause.view().find("has not finished"), std::string::npos) << hung->cause.view();
  EXPECT_EQ(picture_of(publish(kNearMm)).rgba, near.rgba);
  EXPECT_FALSE(failure_);
}

TEST_F(GpuHangTest, IsFoundWhereOnlyTheCounterStandsStill) {
  start(impatient());
  const Picture near = picture_of(publish(kNearMm));
  inject({.call = GpuCall::kSemaphoreValue, .times = kAlways, .stands = true});
  publish(kFarMm);
  EXPECT_TRUE(eventually([this] { return counters_.devices_lost.value() == 1; }));
  clear_gpu_faults();
  EXPECT_EQ(picture_of(publish(kNearMm)).rgba, near.rgba);
  EXPECT_EQ(counters_.devices_lost.value(), 1U);
  EXPECT_FALSE(failure_);
}

TEST_F(GpuHangTest, IsNotWhatASlowGpuDoes) {
  start(Watchdog::Limits{.least_slow_ns = 100'000'000, .least_hung_ns = kLongestNs});
  const Picture near = picture_of(publish(kNearMm));
  inject({.call = GpuCall::kSubmit, .delayed = true});
  publish(kFarMm);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return !seen_.empty() && seen_.back().state == State::kSlow;
  }));
  EXPECT_EQ(pictures_.newest(), nullptr);
  clear_gpu_faults();
  EXPECT_NE(picture_of(2).rgba, near.rgba);
  EXPECT_TRUE(eventually([this] {
    read_others();
    return seen_.back().state == State::kRunning;
  }));
  EXPECT_EQ(counters_.devices_lost.value(), 0U);
}

TEST_F(GpuHangTest, DoesNotKeepTheThreadFromItsEnd) {
  start();  // with the limits of production, so that the hang is not found before the end
  picture_of(publish(kNearMm));
  inject({.call = GpuCall::kSubmit, .hangs = true});
  const std::uint64_t before = gpu_faults_so_far();
  publish(kFarMm);
  EXPECT_TRUE(eventually([before] { return gpu_faults_so_far() > before; }));
  constexpr std::int64_t kHalfSecondNs = 500'000'000;
  const std::int64_t asked_ns = now_ns();
  EXPECT_FALSE(thread_->end(kHalfSecondNs)) << "the device is still there";
  EXPECT_LT(now_ns() - asked_ns, 20 * kHalfSecondNs)
      << "a busy machine may be late, but not by the watchdog's limit";
  EXPECT_EQ(counters_.volumes_skipped.value(), 1U);
  clear_gpu_faults();
  EXPECT_TRUE(eventually([this] { return thread_->end(0); })) << "the device answers again, and is destroyed";
}

class LostRendererTest : public GpuTest {
 protected:
  const FanGeometry geometry_ = kSmallFan;
  const std::vector<double> angles_rad_ = {-0.4, -0.2, 0, 0.2, 0.4};
  const Scene scene_ = scene_for(geometry_, angles_rad_.front(), angles_rad_.back());
  Volume plate(double depth_mm) const {
    return made_volume(geometry_, angles_rad_, [=](const Point& at) { return at.y_mm > depth_mm ? 150 : 5; });
  }
};

TEST_F(LostRendererTest, CollectsNothingWhereTheCounterCannotBeRead) {
  // A device of its own: the one of the other tests must not be lost.
  auto device = open_device("");
  ASSERT_TRUE(device);
  RenderCounters counters;
  auto made = Renderer::create({.size = {64, 64},
                                .geometry = geometry_,
                                .first_angle_rad = angles_rad_.front(),
                                .last_angle_rad = angles_rad_.back(),
                                .frame_capacity = 5},
                               {.gpu = *device->gpu, .counters = counters}, {.revision = 1, .scene = scene_});
  ASSERT_TRUE(made);
  Renderer& renderer = **made;
  ASSERT_TRUE(renderer.load(plate(40)));
  next_picture(renderer);
  ASSERT_TRUE(renderer.load(plate(60)));
  const std::uint64_t lit = counters.pass2_runs.value();
  while (counters.pass2_runs.value() == lit) {
    ASSERT_TRUE(renderer.advance());
    ASSERT_TRUE(renderer.wait(1'000'000'000));
  }
  inject({.call = GpuCall::kSemaphoreValue, .times = kAlways});
  Picture picture;
  EXPECT_FALSE(renderer.collect(picture)) << "the memory may hold the picture before";
  const auto waited = renderer.wait(1'000'000'000);
  ASSERT_FALSE(waited);
  EXPECT_EQ(waited.error().code, ErrorCode::kLost);
  EXPECT_FALSE(renderer.advance());
  EXPECT_FALSE(renderer.collect(picture));
  clear_gpu_faults();
}

TEST_F(LostRendererTest, RendersNoVolumeThatTheGpuRefusesAndSaysWhy) {
  RenderCounters counters;
  auto renderer = made_renderer(geometry_, angles_rad_, {64, 64}, scene_, counters);
  EXPECT_TRUE(render_once(*renderer, plate(40)));
  FanGeometry deeper = geometry_;
  deeper.rows = 70;
  const Volume refused = made_volume(deeper, angles_rad_, [](const Point&) { return 5; });
  inject({.call = GpuCall::kAllocateMemory, .result = VK_ERROR_OUT_OF_DEVICE_MEMORY});
  const auto none = render_once(*renderer, refused);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(none.error().message.find("VK_ERROR_OUT_OF_DEVICE_MEMORY"), std::string::npos);
  EXPECT_TRUE(render_once(*renderer, refused)) << "the memory is there again";
}

}  // namespace
}  // namespace fanlight::test::gpu_fault_tests
