// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recover_recording.hpp"

#include <cstring>

#include "tests/recording/recorder_fixture.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/igs_file.hpp"

namespace fanlight::test {
namespace {

/// A recorder that was killed leaves two files; each test puts back what it wants of them.
class RecoveryTest : public RecorderTest {
 protected:
  static constexpr std::uint64_t kFrames = 12;

  RecoveryTest() {
    auto segment = SegmentWriter::create(segment_paths(path_, 1), facts());
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      EXPECT_TRUE(segment->append({.stamp = stamp(i)}, pixels(i)));
      EXPECT_TRUE(segment->flush());
    }
    frames_ = text_of(segment->paths().frames);
    pixels_ = text_of(segment->paths().pixels);
  }

  static RecordingFacts facts() {
    return {.source = "phantom:", .geometry = geometry(), .frames_per_volume = kFramesInSweep};
  }

  Result<FinishedRecording> recover(std::string_view frames, std::string_view pixels) {
    std::filesystem::remove(path_);
    const SegmentPaths paths = segment_paths(path_, 1);
    write_file(paths.frames, frames);
    write_file(paths.pixels, pixels);
    return recover_recording(path_, {});
  }

  std::string frames_;
  std::string pixels_;
};

TEST_F(RecoveryTest, KeepsEveryWholeFrameOfEveryTruncation) {
  const std::size_t record = 56;
  const std::size_t begin = frames_.size() - kFrames * record;
  for (std::size_t size = 0; size <= frames_.size(); ++size) {
    const std::uint64_t whole = size < begin ? 0 : (size - begin) / record;
    const auto recovered = recover(std::string_view(frames_).substr(0, size), pixels_);
    ASSERT_EQ(recovered.has_value(), whole > 0) << size;
    if (recovered) {
      EXPECT_EQ(recovered->frames, whole);
    }
  }
  for (std::size_t size = 0; size <= pixels_.size(); ++size) {
    const std::uint64_t whole = size / (kColumns * kRows);
    const auto recovered = recover(frames_, std::string_view(pixels_).substr(0, size));
    ASSERT_EQ(recovered.has_value(), whole > 0) << size;
    if (!recovered) continue;
    EXPECT_EQ(recovered->frames, whole);
    if (whole < 2) continue;
    const Recording shorter = open(path_);
    EXPECT_EQ(shorter.frame_pixels(whole - 1)[0], whole);
  }
}

TEST_F(RecoveryTest, KeepsWhatFollowsADamagedFrame) {
  std::string holed = pixels_;
  std::memset(holed.data() + 7 * kColumns * kRows + 3, 0, 5);  // pages that did not reach the disk
  for (const char* const name : {"x.igs.mha", "x.igs.mhd"}) {
    path_ = folder_ / name;
    const auto recovered = recover(frames_, holed);
    ASSERT_TRUE(recovered) << recovered.error().message;
    EXPECT_EQ(recovered->frames, kFrames);
    EXPECT_EQ(recovered->frames_damaged, 1U);
    const Recording recording = open(path_);
    EXPECT_EQ(recording.stream()->frames[7].fault, FrameFault::kDamaged);
    EXPECT_EQ(recording.frame_pixels(7)[0], 0);
    EXPECT_EQ(recording.stream()->frames[8].fault, FrameFault::kNone);
    EXPECT_EQ(recording.frame_pixels(8)[0], 9);
  }
}

TEST_F(RecoveryTest, WritesNothingInPlaceOfAnother) {
  write_file(folder_ / "y.igs.raw", "someone's");
  path_ = folder_ / "y.igs.mhd";
  const auto refused = recover(frames_, pixels_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("y.igs.raw exists already"), std::string::npos);
  EXPECT_EQ(text_of(folder_ / "y.igs.raw"), "someone's");
  EXPECT_EQ(segments_of(path_).size(), 1U);
}

TEST_F(RecoveryTest, KeepsTheOtherSegmentsWhereOneIsMissing) {
  const SegmentPaths second = segment_paths(path_, 2);
  write_file(second.frames, frames_);  // without its pixels
  const auto recovered = recover(frames_, pixels_);
  ASSERT_TRUE(recovered) << recovered.error().message;
  EXPECT_EQ(recovered->frames, kFrames);
}

TEST_F(RecoveryTest, AnswersForEveryChangedByte) {
  for (std::size_t at = 0; at < frames_.size(); ++at) {
    std::string changed = frames_;
    changed[at] = static_cast<char>(changed[at] ^ (1 << (at % 8)));
    const auto recovered = recover(changed, pixels_);
    if (recovered) {
      EXPECT_LT(recovered->frames - recovered->frames_damaged, kFrames) << at;
    }
  }
}

TEST_F(RecoveryTest, HappensWhenTheRecordingIsOpened) {
  const Recording recording = open(path_);
  EXPECT_EQ(recording.summary().frames, kFrames);
  ASSERT_EQ(recording.summary().notes.size(), 1U);
  EXPECT_NE(recording.summary().notes[0].find("cut off"), std::string::npos);
  EXPECT_EQ(files(), std::set<std::string>{"sweeps.igs.mha"});
  EXPECT_TRUE(open(path_).summary().notes.empty());
}

TEST_F(RecoveryTest, HappensWhenARecorderBegins) {
  recorder_ = std::make_unique<Recorder>(source_, bell_, Recorder::Config{.folder = folder_.path()});
  wait_for([this] { return status_.finished == 1; });
  EXPECT_EQ(status_.last_frames, kFrames);
  EXPECT_EQ(files(), std::set<std::string>{"sweeps.igs.mha"});
}

TEST_F(RecoveryTest, LeavesNothingOfAFinishedRecording) {
  // A kill while the segments are removed: the file is whole and has its second name.
  const auto cut_off = [this] {
    ASSERT_TRUE(recover(frames_, pixels_));
    write_file(segment_paths(path_, 1).frames, frames_);
    std::filesystem::create_hard_link(path_, path_.string() + ".rec-finished");
  };
  cut_off();
  const auto finished = recover_recording(path_, {});
  ASSERT_FALSE(finished);
  EXPECT_NE(finished.error().message.find("is a finished recording"), std::string::npos);
  EXPECT_EQ(files(), std::set<std::string>{"sweeps.igs.mha"});

  cut_off();
  recorder_ = std::make_unique<Recorder>(source_, bell_, Recorder::Config{.folder = folder_.path()});
  wait_for([this] { return files() == std::set<std::string>{"sweeps.igs.mha"}; });
}

TEST_F(RecoveryTest, LeavesNothingOfAFinishedPair) {
  const std::filesystem::path pair = folder_ / "sweeps.igs.mhd";
  ASSERT_TRUE(recover(frames_, pixels_));
  std::filesystem::rename(path_, pair);
  write_file(segment_paths(path_, 1).frames, frames_);
  std::filesystem::create_hard_link(pair, path_.string() + ".rec-finished");
  const auto finished = recover_recording(path_, {});
  ASSERT_FALSE(finished);
  EXPECT_NE(finished.error().message.find("sweeps.igs.mhd is a finished recording"), std::string::npos)
      << finished.error().message;
  EXPECT_EQ(files(), std::set<std::string>{"sweeps.igs.mhd"});
}

TEST_F(RecoveryTest, LeavesAFinishedPairAlone) {
  // A kill before the second name, on a file system without such names: the pixels are the segment's own
  // file.
  const std::filesystem::path pair = folder_ / "pair.igs.mhd";
  const SegmentPaths paths = segment_paths(pair, 1);
  write_file(paths.frames, frames_);
  write_file(paths.pixels, pixels_);
  ASSERT_TRUE(recover_recording(pair, {}));
  std::filesystem::create_hard_link(folder_ / "pair.igs.raw", paths.pixels);
  write_file(paths.frames, std::string_view(frames_).substr(0, frames_.size() - 100));
  FinishProgress progress;
  EXPECT_FALSE(finish_recording({paths}, pair, {}, progress, std::stop_token()));
  EXPECT_EQ(text_of(folder_ / "pair.igs.raw"), pixels_);
}

TEST_F(RecoveryTest, RemovesTheSecondNameOfADeletedFile) {
  ASSERT_TRUE(recover(frames_, pixels_));
  std::filesystem::rename(path_, path_.string() + ".rec-finished");
  recorder_ = std::make_unique<Recorder>(source_, bell_, Recorder::Config{.folder = folder_.path()});
  wait_for([this] { return files().empty(); });
}

TEST_F(RecoveryTest, KeepsSegmentsBesideAFileOfAnotherProgram) {
  ASSERT_TRUE(recover(frames_, pixels_));
  write_file(segment_paths(path_, 1).frames, frames_);
  write_file(segment_paths(path_, 1).pixels, pixels_);
  write_file(path_.string() + ".rec-finished", "of another file");
  const auto refused = recover_recording(path_, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("rename it"), std::string::npos) << refused.error().message;
  EXPECT_TRUE(std::filesystem::exists(segment_paths(path_, 1).pixels));
}

TEST_F(RecoveryTest, RefusesWithASentence) {
  const auto missing = recover_recording(folder_ / "none.igs.mha", {});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(recover_recording(folder_ / "x.png", {}).error().code, ErrorCode::kInvalidArgument);
  ASSERT_TRUE(recover(frames_, pixels_));
  const auto finished = recover_recording(path_, {});
  ASSERT_FALSE(finished);
  EXPECT_NE(finished.error().message.find("is a finished recording"), std::string::npos);
}

TEST_F(RecoveryTest, WaitsForTheRecorder) {
  begin({.path = folder_ / "live.igs.mha"});
  put(0);
  wait_for([this] { return status_.frames == 1; });
  const auto refused = recover_recording(folder_ / "live.igs.mha", {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("another process records it or finishes it"), std::string::npos);
  end();
}

}  // namespace
}  // namespace fanlight::test
