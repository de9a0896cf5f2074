// SPDX-License-Identifier: Apache-2.0
// Refresh::kFrame: each frame replaces the frame at its index in the last sweep. The picture after casting
// the dirty tiles equals the picture of a whole cast of the same frames, bit by bit.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "tests/gpu/seeded_case.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::rolling_tests {
namespace {

/// The frames of a first sweep and of the next one, by ascending angle.
class Sweeps {
 public:
  explicit Sweeps(const SeededCase& given)
      : angles_rad_(sorted(given.angles_rad)),
        first_(made_volume(given.geometry, angles_rad_, given.grey)),
        second_(made_volume(given.geometry, angles_rad_, given.moved_grey)) {}

  std::uint32_t frames() const { return static_cast<std::uint32_t>(angles_rad_.size()); }

  /// A volume of frames of both sweeps. `newer[i]`: frame i is of the second sweep. A frame has the same
  /// commit number in every volume.
  Volume mixed(const std::vector<bool>& newer, std::uint64_t id) const {
    Volume volume(first_.geometry(), frames());
    for (std::uint32_t index = 0; index < frames(); ++index) {
      const QueuedFrame frame = queued_frame(index, newer[index]);
      std::ranges::copy(frame.pixels, volume.next_frame_pixels().begin());
      volume.add_frame(frame.stamp);
    }
    volume.sort_by_angle();
    volume.stamp().volume_id = id;
    return volume;
  }

  QueuedFrame queued_frame(std::uint32_t index, bool newer) const {
    const Volume& from = newer ? second_ : first_;
    return {.stamp = {.sequence = index + (newer ? frames() : 0U),
                      .angle_rad = angles_rad_[index],
                      .commit_number = 1 + index + (newer ? frames() : 0U)},
            .geometry = from.geometry(),
            .pixels = from.frame_pixels(index)};
  }

 private:
  static std::vector<double> sorted(std::vector<double> angles_rad) {
    std::ranges::sort(angles_rad);
    return angles_rad;
  }

  std::vector<double> angles_rad_;
  Volume first_;
  Volume second_;
};

class RollingTest : public GpuTest, public testing::WithParamInterface<std::uint32_t> {
 protected:
  struct Shown {
    Picture picture;
    std::vector<float> cast_mm;
  };
  static Shown shown(Renderer& renderer) {
    Shown now{.picture = next_picture(renderer), .cast_mm = {}};
    now.cast_mm = renderer.read_depth()->cast_mm;
    return now;
  }

  /// By a renderer that has seen no other volume.
  static Shown whole(const SeededCase& given, const Scene& scene, const Volume& volume) {
    RenderCounters counters;
    const auto renderer = made_renderer(given.geometry, given.angles_rad, given.size, scene, counters);
    if (auto loaded = renderer->load(volume); !loaded) throw std::runtime_error(loaded.error().message);
    return shown(*renderer);
  }

  static Scene rolling_scene(const SeededCase& given) {
    Scene scene = given.scene;
    scene.refresh = Refresh::kFrame;
    scene.filter.steady = 0;       // there is no last volume to filter with
    scene.filter.seam_frames = 0;  // a whole cast knows no picture before it (seam_test.cpp)
    return scene;
  }
};

TEST_P(RollingTest, ShowsWhatAWholeCastOfTheSameFramesShows) {
  const SeededCase given = seeded_case(GetParam());
  const Scene scene = rolling_scene(given);
  const Sweeps sweeps(given);
  RenderCounters counters;
  const auto renderer = made_renderer(given.geometry, given.angles_rad, given.size, scene, counters);
  std::vector<bool> newer(sweeps.frames(), false);
  ASSERT_TRUE(renderer->load(sweeps.mixed(newer, 1)));
  next_picture(*renderer);

  std::vector<std::uint32_t> order(sweeps.frames());
  std::iota(order.begin(), order.end(), 0U);
  if (GetParam() % 2 == 1) std::ranges::reverse(order);  // backward sweeps, too
  EchoLevels levels;
  for (const std::uint32_t index : order) {
    ASSERT_TRUE(renderer->wants_frame());
    renderer->take_frame(sweeps.queued_frame(index, true));
    newer[index] = true;
    const Shown now = shown(*renderer);
    const Shown afresh = whole(given, scene, sweeps.mixed(newer, 1));
    ASSERT_EQ(now.cast_mm, afresh.cast_mm) << "after frame " << index;
    ASSERT_EQ(now.picture.rgba, afresh.picture.rgba) << "after frame " << index;
    EXPECT_EQ(now.picture.stamp.volume.volume_id, 1U);
    levels = now.picture.stamp.levels;
  }
  const auto casts = counters.pass1_runs.value();
  ASSERT_TRUE(renderer->load(sweeps.mixed(newer, 2)));
  const Shown complete = shown(*renderer);
  EXPECT_EQ(complete.picture.stamp.volume.volume_id, 2U);
  EXPECT_EQ(complete.picture.rgba, whole(given, scene, sweeps.mixed(newer, 2)).picture.rgba);
  // Nothing is left to cast, unless the whole sweep has other values for what the scene leaves to the data.
  EXPECT_EQ(counters.pass1_runs.value(), casts + (complete.picture.stamp.levels == levels ? 0 : 1));
}

TEST_P(RollingTest, MendsWhatDidNotComeAheadOfItsVolume) {
  const SeededCase given = seeded_case(GetParam());
  const Scene scene = rolling_scene(given);
  const Sweeps sweeps(given);
  RenderCounters counters;
  const auto renderer = made_renderer(given.geometry, given.angles_rad, given.size, scene, counters);
  ASSERT_TRUE(renderer->load(sweeps.mixed(std::vector<bool>(sweeps.frames(), false), 1)));
  next_picture(*renderer);
  renderer->take_frame(sweeps.queued_frame(sweeps.frames() / 2, true));
  next_picture(*renderer);
  const Volume second = sweeps.mixed(std::vector<bool>(sweeps.frames(), true), 2);
  ASSERT_TRUE(renderer->load(second));
  const Shown now = shown(*renderer);
  const Shown afresh = whole(given, scene, second);
  EXPECT_EQ(now.cast_mm, afresh.cast_mm);
  EXPECT_EQ(now.picture.rgba, afresh.picture.rgba);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RollingTest, testing::Range(0U, 12U));

}  // namespace
}  // namespace fanlight::test::rolling_tests
