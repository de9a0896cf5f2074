// SPDX-License-Identifier: Apache-2.0
// A recording of the simulated probe, replayed, gives the assembler what the probe gave it.
#include <stop_token>

#include "acquisition/offline_volumes.hpp"
#include "acquisition/open_source.hpp"
#include "acquisition/record/frame_pump.hpp"
#include "acquisition/replay/replay_source.hpp"
#include "tests/recording/recorder_fixture.hpp"

namespace fanlight::test {
namespace {

class ReplayedStampsTest : public RecorderTest, public testing::WithParamInterface<const char*> {
 protected:
  static std::unique_ptr<FrameSource> source_of(const std::string& text) {
    static Doorbell bell;
    static ProbeLink probe(bell, bell);
    auto source = open_source(text, {.pace = SourcePace::kAsFastAsTaken}, probe);
    if (!source) {
      ADD_FAILURE() << source.error().message;
      std::abort();
    }
    return *std::move(source);
  }

  void record(const std::string& text) {
    const auto source = source_of(text);
    source_ = source->description();
    begin({.path = path_});
    PumpedFrames pumped;
    ASSERT_TRUE(pump_frames(*source, recorder_->tap(), FullQueue::kWait, {}, pumped));
    end();
  }

  /// All that the renderer reads of a volume.
  struct Seen {
    std::vector<double> angles_rad;
    std::vector<std::uint8_t> pixels;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    std::uint64_t first_number = 0;
    std::uint64_t last_number = 0;
    std::uint32_t missing = 0;
    double correction_rad = 0;
    SweepDirection direction{};
    bool operator==(const Seen&) const = default;
  };
  static std::vector<Seen> volumes_of(FrameSource& source) {
    OfflineVolumes volumes(source);
    std::vector<Seen> seen;
    for (;;) {
      const auto volume = volumes.next();
      if (!volume || !*volume) return seen;
      const VolumeStamp& stamp = (*volume)->stamp();
      Seen one{.first = stamp.first_frame_sequence,
               .last = stamp.last_frame_sequence,
               .first_number = stamp.first_recorded_number,
               .last_number = stamp.last_recorded_number,
               .missing = stamp.frames_missing,
               .correction_rad = stamp.angle_correction_rad,
               .direction = stamp.direction};
      for (const std::uint32_t i : (*volume)->by_angle()) {
        one.angles_rad.push_back((*volume)->angles_rad()[i]);
        const auto pixels = (*volume)->frame_pixels(i);
        one.pixels.insert(one.pixels.end(), pixels.begin(), pixels.end());
      }
      seen.push_back(std::move(one));
    }
  }
};

TEST_P(ReplayedStampsTest, GiveTheSameVolumes) {
  const std::string text = GetParam();
  record(text);
  const auto live = volumes_of(*source_of(text));
  const auto replayed = volumes_of(*source_of(path_.string()));
  ASSERT_GE(live.size(), 4U);
  ASSERT_EQ(replayed.size(), live.size());
  for (std::size_t i = 0; i < live.size(); ++i) EXPECT_TRUE(replayed[i] == live[i]) << i;
}

INSTANTIATE_TEST_SUITE_P(
    All, ReplayedStampsTest,
    testing::Values(
        "phantom:scene=relief,probe=r1,columns=64,rows=64,frames=20,volumes=6",
        "phantom:scene=relief,probe=r1,columns=64,rows=64,frames=20,volumes=6,lag=1,jitter=0.3,lost=3",
        "phantom:scene=relief,probe=r1,columns=64,rows=64,frames=20,volumes=6,index=off,lag=1,lost=3,turning="
        "3",
        "phantom:scene=relief,probe=r1,columns=64,rows=64,frames=20,volumes=9,scan=convex,lost=8"));

TEST_F(ReplayedStampsTest, GoOnInFurtherPasses) {
  record("phantom:scene=relief,probe=r1,columns=64,rows=64,frames=10,volumes=3,lost=2");
  auto source = ReplaySource::create({.recording = {.path = path_, .geometry_path = {}},
                                      .pace = ReplaySource::Pace::kAsFastAsTaken,
                                      .ending = ReplaySource::Ending::kLoop});
  ASSERT_TRUE(source);
  std::uint64_t next_sequence = 0;
  std::uint64_t volume = 0;
  for (int i = 0; i < 100; ++i) {
    const auto frame = (*source)->next_frame({}).value();
    ASSERT_TRUE(frame);
    EXPECT_GE(frame->sequence, next_sequence) << i;
    EXPECT_GE(frame->volume_index, volume) << i;
    next_sequence = frame->sequence + 1;
    volume = frame->volume_index;
  }
  EXPECT_GE(volume, 9U);
}

/// By these numbers, measurements find their volume again.
TEST_F(ReplayedStampsTest, KeepTheNumbersOfTheRecordingInEachPass) {
  for (const char* const options : {"", ",index=off"}) {
    path_ = folder_ / (std::string("sweeps") + (*options == 0 ? "" : "-unnumbered") + ".igs.mha");
    record(std::string("phantom:scene=relief,probe=r1,columns=64,rows=64,frames=10,volumes=3,lost=2") +
           options);
    const auto live = volumes_of(*source_of(path_.string()));
    ASSERT_EQ(live.size(), 3U) << options;
    for (const auto ending : {ReplaySource::Ending::kLoop, ReplaySource::Ending::kToAndFro}) {
      auto source = ReplaySource::create({.recording = {.path = path_, .geometry_path = {}},
                                          .pace = ReplaySource::Pace::kAsFastAsTaken,
                                          .ending = ending});
      ASSERT_TRUE(source);
      OfflineVolumes volumes(**source);
      for (std::size_t i = 0; i < 9; ++i) {
        const bool backward = ending == ReplaySource::Ending::kToAndFro && i / 3 == 1;
        const VolumeStamp stamp = (*volumes.next())->stamp();
        const Seen& same = live[backward ? 2 - i % 3 : i % 3];
        const auto [first, last] = std::minmax(stamp.first_recorded_number, stamp.last_recorded_number);
        // Where sweeps have no numbers, a frame more or less may count to the first sweep of a pass.
        const double slack = *options == 0 ? 0 : 1;
        EXPECT_NEAR(static_cast<double>(first), static_cast<double>(same.first), slack) << options << i;
        EXPECT_NEAR(static_cast<double>(last), static_cast<double>(same.last), slack) << options << i;
        EXPECT_EQ(stamp.first_recorded_number > stamp.last_recorded_number, backward) << options << i;
      }
    }
  }
}

}  // namespace
}  // namespace fanlight::test
