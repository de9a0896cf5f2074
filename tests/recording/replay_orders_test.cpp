// SPDX-License-Identifier: Apache-2.0
// A recording that is played under orders: pause, step, seek, speed, ending; and its file that changes
// meanwhile.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/replay/replay_source.hpp"
#include "proto/base/clock.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

using Wish = ReplayOrder::Wish;

constexpr std::uint32_t kFramesASweep = 4;
constexpr std::uint32_t kSweeps = 3;
constexpr std::uint32_t kSide = 64;  // pixels of a frame

struct PlayedFrame {
  FrameStamp stamp;
  int mark;  ///< first pixel: 1 for the first frame of the recording
};

class ReplayOrdersTest : public testing::Test {
 protected:
  ReplaySource& make(ReplaySource::Config config = {}, bool compressed = false) {
    NamedFile file = fan_recording(kFramesASweep, kSweeps, 20);
    file.compressed = compressed;
    // Larger than what the C library reads ahead.
    file.columns = file.rows = kSide;
    file.pixels.assign(std::size_t{kSide} * kSide * file.frames.size(), 0);
    for (std::size_t i = 0; i < file.frames.size(); ++i)
      file.pixels[i * kSide * kSide] = static_cast<std::uint8_t>(i + 1);
    write_file(path_, file.bytes());
    config.recording.path = path_;
    if (config.pace == ReplaySource::Pace::kRecorded && config.speed == 1)
      config.pace = ReplaySource::Pace::kAsFastAsTaken;
    config.link = &link_;
    source_ = ReplaySource::create(config).value();
    return *source_;
  }

  /// Frames up to the next rest, or as many as given.
  std::vector<PlayedFrame> take(std::size_t most = 1000) {
    std::vector<PlayedFrame> frames;
    std::vector<std::uint8_t> pixels(source_->description().geometry.frame_bytes());
    while (frames.size() < most) {
      const auto next = source_->next_frame({}).value();
      if (!next) {
        EXPECT_TRUE(source_->rests());
        break;
      }
      EXPECT_EQ(source_->read_pixels(pixels, {}), FrameFault::kNone);
      frames.push_back({*next, pixels[0]});
    }
    return frames;
  }

  /// The marks of the frames; empty where volume, direction or sequence do not fit a sweep of its own.
  static std::vector<int> marks_of_sweep(const std::vector<PlayedFrame>& frames) {
    std::vector<int> marks;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const FrameStamp& stamp = frames[i].stamp;
      const FrameStamp& first = frames[0].stamp;
      if (stamp.volume_index != first.volume_index || stamp.frame_index != i ||
          stamp.sequence != first.sequence + i || stamp.direction != first.direction ||
          (i > 0 && stamp.after_interruption))
        return {};
      marks.push_back(frames[i].mark);
    }
    return marks;
  }

  ReplayStatus status() {
    if (const ReplayStatus* const newest = link_.status.newest()) status_ = *newest;
    return status_;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "sweeps.igs.mha";
  Doorbell server_bell_;
  ReplayLink link_{server_bell_};
  std::unique_ptr<ReplaySource> source_;
  ReplayStatus status_;
};

TEST_F(ReplayOrdersTest, StepsSweepBySweepAndBack) {
  make({.ending = ReplayEnding::kLoop, .paused = true});
  EXPECT_EQ(status().sweeps, kSweeps);
  const auto first = take();
  EXPECT_EQ(marks_of_sweep(first), (std::vector{1, 2, 3, 4}));
  EXPECT_EQ(status().state, ReplayStatus::State::kPaused);

  link_.send({.wish = Wish::kStep});
  const auto second = take();
  EXPECT_EQ(marks_of_sweep(second), (std::vector{5, 6, 7, 8}));
  EXPECT_FALSE(second[0].stamp.after_interruption) << "it continues the sweep before";
  EXPECT_EQ(second[0].stamp.volume_index, first[0].stamp.volume_index + 1);
  EXPECT_EQ(status().sweep, 1U);

  link_.send({.wish = Wish::kStep, .sweeps = -1});
  const auto again = take();
  EXPECT_EQ(marks_of_sweep(again), (std::vector{1, 2, 3, 4}));
  EXPECT_TRUE(again[0].stamp.after_interruption);
  EXPECT_GT(again[0].stamp.volume_index, second[0].stamp.volume_index);
  EXPECT_GT(again[0].stamp.sequence, second.back().stamp.sequence);

  link_.send({.wish = Wish::kStep, .sweeps = 7});
  EXPECT_EQ(take().size(), 2 * kFramesASweep) << "it stops at the end of the recording";
  EXPECT_EQ(status().sweep, 2U);
  link_.send({.wish = Wish::kStep});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{1, 2, 3, 4})) << "the loop continues";
}

TEST_F(ReplayOrdersTest, ShowsTheSweepOfAFrame) {
  make({.ending = ReplayEnding::kToAndFro});
  const std::uint64_t number = *take(kFramesASweep + 2).back().stamp.recorded_number;  // in the second sweep
  link_.send({.wish = Wish::kFrame, .number = 0});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{1, 2, 3, 4})) << "before the recording: its first sweep";
  EXPECT_EQ(status().state, ReplayStatus::State::kPaused);
  link_.send({.wish = Wish::kFrame, .number = number});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{5, 6, 7, 8}));
  link_.send({.wish = Wish::kFrame, .number = ~std::uint64_t{0}});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{9, 10, 11, 12})) << "beyond it: its last one";
  link_.send({.wish = Wish::kPlay});
  take(kFramesASweep + 1);
  EXPECT_TRUE(status().backward);
  link_.send({.wish = Wish::kFrame, .number = number});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{8, 7, 6, 5})) << "as this pass plays it";
}

TEST_F(ReplayOrdersTest, StepsInABackwardPassGoOnBackward) {
  make({.ending = ReplayEnding::kToAndFro});
  take(kSweeps * kFramesASweep + 1);  // into the backward pass
  link_.send({.wish = Wish::kPause});
  link_.send({.wish = Wish::kStep});
  take();
  EXPECT_TRUE(status().backward);
  EXPECT_EQ(status().sweep, 2U) << "the sweep under way";
  link_.send({.wish = Wish::kStep});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{8, 7, 6, 5}));
  link_.send({.wish = Wish::kStep, .sweeps = -1});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{12, 11, 10, 9}));
}

TEST_F(ReplayOrdersTest, SeeksToTheSweepAtATime) {
  make({.ending = ReplayEnding::kLoop});
  take(2);
  link_.send({.wish = Wish::kSeek, .time_s = 0.95});  // frames come each 0.1 s: the third sweep begins at 0.8
  const auto frames = take(6);
  EXPECT_EQ(frames[0].mark, 9);
  EXPECT_TRUE(frames[0].stamp.after_interruption);
  EXPECT_EQ(frames[4].mark, 1) << "it plays on";
  link_.send({.wish = Wish::kSeek, .time_s = 1e9});
  EXPECT_EQ(take(1)[0].mark, 9);
  link_.send({.wish = Wish::kPause});
  link_.send({.wish = Wish::kSeek, .time_s = 0.5});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{5, 6, 7, 8})) << "where it is paused, it shows the sweep";
}

TEST_F(ReplayOrdersTest, APauseWithinASweepLosesNothing) {
  make({.ending = ReplayEnding::kLoop});
  const auto before = take(2);
  link_.send({.wish = Wish::kPause});
  std::vector<PlayedFrame> after;
  std::jthread player([&] { after = take(1); });
  for (int i = 0; i < 1000 && status().state != ReplayStatus::State::kPaused; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_EQ(status().state, ReplayStatus::State::kPaused);
  EXPECT_TRUE(after.empty());
  link_.send({.wish = Wish::kPlay});
  player.join();
  ASSERT_EQ(after.size(), 1U);
  EXPECT_EQ(after[0].mark, 3);
  EXPECT_EQ(after[0].stamp.sequence, before[1].stamp.sequence + 1);
  EXPECT_EQ(after[0].stamp.volume_index, before[1].stamp.volume_index);
  EXPECT_FALSE(after[0].stamp.after_interruption);
  EXPECT_GT(after[0].stamp.capture_time_ns, before[1].stamp.capture_time_ns);
}

TEST_F(ReplayOrdersTest, APausedPlayerStops) {
  make({.ending = ReplayEnding::kLoop, .paused = true});
  take();
  std::jthread player([&](const std::stop_token& stop) {
    EXPECT_FALSE(source_->next_frame(stop).value().has_value());
    EXPECT_FALSE(source_->rests());
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

TEST_F(ReplayOrdersTest, AnotherSpeedHoldsFromTheNextFrame) {
  make({.speed = 1000, .ending = ReplayEnding::kLoop});
  const auto quick = take(3);
  EXPECT_NEAR(static_cast<double>(quick[2].stamp.capture_time_ns - quick[1].stamp.capture_time_ns), 1e5, 2);
  link_.send({.wish = Wish::kSpeed, .speed = 50});
  const auto slow = take(3);
  EXPECT_NEAR(static_cast<double>(slow[2].stamp.capture_time_ns - slow[1].stamp.capture_time_ns), 2e6, 2);
  EXPECT_EQ(status().speed, 50);
}

class ReplayFromFileTest : public ReplayOrdersTest, public testing::WithParamInterface<bool> {};

TEST_P(ReplayFromFileTest, PlaysAgainAfterItsEnd) {
  make({.ending = ReplayEnding::kOnce}, GetParam());
  EXPECT_EQ(take().size(), kSweeps * kFramesASweep);
  EXPECT_EQ(status().state, ReplayStatus::State::kEnded);
  link_.send({.wish = Wish::kPlay});
  const auto again = take();
  EXPECT_EQ(again.size(), kSweeps * kFramesASweep);
  EXPECT_EQ(again[0].mark, 1);
  EXPECT_TRUE(again[0].stamp.after_interruption);
  link_.send({.wish = Wish::kSeek, .time_s = 0.5});
  EXPECT_EQ(marks_of_sweep(take()), (std::vector{5, 6, 7, 8}));
  link_.send({.wish = Wish::kEnding, .ending = ReplayEnding::kLoop});
  link_.send({.wish = Wish::kPlay});
  EXPECT_EQ(take(5)[4].mark, 1);
}

INSTANTIATE_TEST_SUITE_P(Compressed, ReplayFromFileTest, testing::Bool());

TEST_F(ReplayOrdersTest, AFileThatShrinksIsToldAndTheRestCanBePlayed) {
  make({.ending = ReplayEnding::kOnce});
  take(2);
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 5 * kSide * kSide);
  link_.send({.wish = Wish::kPlay});
  std::vector<std::uint8_t> pixels(source_->description().geometry.frame_bytes());
  FrameFault fault = FrameFault::kNone;
  for (int i = 0; i < 20 && fault == FrameFault::kNone; ++i) {
    ASSERT_TRUE(source_->next_frame({}).value().has_value());
    fault = source_->read_pixels(pixels, {});
  }
  EXPECT_EQ(fault, FrameFault::kCut);
  std::vector<PlayedFrame> after;
  std::jthread player([&] { after = take(1); });
  for (int i = 0; i < 1000 && status().state != ReplayStatus::State::kFailed; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_EQ(status().state, ReplayStatus::State::kFailed);
  EXPECT_NE(status().trouble.find("sweeps.igs.mha"), std::string::npos) << status().trouble;
  link_.send({.wish = Wish::kPlay});
  player.join();
  ASSERT_EQ(after.size(), 1U);
  EXPECT_EQ(after[0].mark, 1);
  EXPECT_EQ(status().file, ReplayStatus::File::kChanged);
}

TEST_F(ReplayOrdersTest, AChangedOrRemovedFileIsTold) {
  make({.ending = ReplayEnding::kOnce});
  take(2);
  EXPECT_EQ(status().file, ReplayStatus::File::kSame);
  std::filesystem::last_write_time(path_,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::seconds(5));
  take(3);
  EXPECT_EQ(status().file, ReplayStatus::File::kChanged);
  std::filesystem::remove(path_);
  take(4);
  EXPECT_EQ(status().file, ReplayStatus::File::kRemoved);
  EXPECT_EQ(take().size(), 3U) << "what was opened is still there";
}

TEST_F(ReplayOrdersTest, EachStepGivesItsVolumeAndEveryFrameIsCounted) {
  ReplaySource& source = make({.ending = ReplayEnding::kLoop, .paused = true});
  AcquisitionCounters counters;
  Doorbell reader_bell;
  Doorbell writer_bell;
  Doorbell ended_bell;
  VolumeRing ring({.geometry = source.description().geometry,
                   .frame_capacity = source.description().frames_per_volume,
                   .slots = 4,
                   .policy = RingPolicy::kNewestWins},
                  {.reader_bell = reader_bell, .writer_bell = writer_bell});
  AcquisitionThread thread({.source = source,
                            .ring = ring,
                            .writer_bell = writer_bell,
                            .counters = counters,
                            .ended_bell = ended_bell});
  const auto published = [&](std::uint64_t wanted) {
    for (int i = 0; i < 1000 && ring.counters().volumes_published.value() < wanted; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return ring.counters().volumes_published.value();
  };
  EXPECT_EQ(published(1), 1U);
  link_.send({.wish = Wish::kStep});
  EXPECT_EQ(published(2), 2U);
  link_.send({.wish = Wish::kStep, .sweeps = -1});
  EXPECT_EQ(published(3), 3U);
  link_.send({.wish = Wish::kSeek, .time_s = 0.9});
  EXPECT_EQ(published(4), 4U);
  EXPECT_EQ(counters.frames_received.value(), 4 * kFramesASweep);
  EXPECT_EQ(counters.frames_assembled.value(), 4 * kFramesASweep);
  EXPECT_EQ(counters.frames_missing.value() + counters.frames_late.value(), 0U);
  EXPECT_EQ(counters.volumes_incomplete.value(), 0U);
  EXPECT_EQ(thread.state(), AcquisitionThread::State::kRunning);
}

TEST_F(ReplayOrdersTest, BeginsWhereItIsTold) {
  make({.ending = ReplayEnding::kOnce, .from_s = 0.5});
  const auto frames = take();
  ASSERT_EQ(frames.size(), 2 * kFramesASweep);
  EXPECT_EQ(frames[0].mark, 5);
  EXPECT_FALSE(ReplaySource::create({.recording = {.path = path_}, .from_s = -1}));
}

}  // namespace
}  // namespace fanlight::test
