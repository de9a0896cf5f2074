// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recorder.hpp"

#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "acquisition/replay/recording_file.hpp"
#include "tests/recording/open_files.hpp"
#include "tests/recording/recorder_fixture.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/file_text.hpp"

namespace fanlight::test {
namespace {

using State = RecordingStatus::State;

struct Shape {
  const char* name;
  const char* file;
  PixelForm form;
  std::set<std::string> files;
};

class RecorderShapeTest : public RecorderTest, public testing::WithParamInterface<Shape> {};

TEST_P(RecorderShapeTest, KeepsEveryStampFaultAndPixel) {
  const std::filesystem::path path = folder_ / GetParam().file;
  begin({.path = path, .form = GetParam().form});
  std::vector<RecordedFrame> given;
  for (std::uint64_t i = 0; i < 4 * kFramesInSweep; ++i) given.push_back({.stamp = stamp(i)});
  given[3].fault = FrameFault::kDamaged;
  given[4].fault = FrameFault::kMisfit;
  std::swap(given[6].stamp, given[7].stamp);  // out of order
  given[12].stamp.after_interruption = true;
  given[12].stamp.frames_in_sweep = 0;
  for (const RecordedFrame& frame : given)
    put(frame.stamp, geometry(), pixels(frame.stamp.sequence), frame.fault);
  end();

  EXPECT_EQ(files(), GetParam().files);
  EXPECT_EQ(status_.finished, 1U);
  EXPECT_EQ(status_.last_frames, given.size());
  EXPECT_EQ(status_.last_trouble, "");
  Recording recording = open(path);
  EXPECT_EQ(recording.summary().geometry, geometry());
  ASSERT_NE(recording.stream(), nullptr);
  EXPECT_EQ(recording.stream()->facts.source, "phantom:");
  EXPECT_EQ(recording.stream()->facts.last_angle_rad, 0.3);
  for (std::size_t i = 0; i < given.size(); ++i) {
    const RecordedFrame& kept = recording.stream()->frames[i];
    const FrameStamp& was = given[i].stamp;
    EXPECT_EQ(kept.fault, given[i].fault) << i;
    EXPECT_EQ(kept.stamp.sequence, was.sequence) << i;
    EXPECT_EQ(kept.stamp.volume_index, was.volume_index) << i;
    EXPECT_EQ(kept.stamp.frame_index, was.frame_index) << i;
    EXPECT_EQ(kept.stamp.frames_in_sweep, was.frames_in_sweep) << i;
    EXPECT_EQ(kept.stamp.direction, was.direction) << i;
    EXPECT_EQ(kept.stamp.angle_rad, was.angle_rad) << i;  // every bit
    EXPECT_EQ(kept.stamp.after_interruption, was.after_interruption) << i;
    const bool usable = given[i].usable();
    EXPECT_EQ(recording.frame_pixels(i)[5], usable ? static_cast<std::uint8_t>(was.sequence + 1) : 0) << i;
  }
  // The times of a PLUS sequence never fall.
  EXPECT_EQ(recording.frames()[6].time_ns, 7 * kFrameNs);
  EXPECT_EQ(recording.frames()[7].time_ns, 7 * kFrameNs);
  EXPECT_EQ(recording.frames()[8].time_ns, 8 * kFrameNs);
}

INSTANTIATE_TEST_SUITE_P(
    All, RecorderShapeTest,
    testing::Values(Shape{"OneFileRaw", "x.igs.mha", PixelForm::kRaw, {"x.igs.mha"}},
                    Shape{"OneFilePacked", "x.igs.mha", PixelForm::kZlib, {"x.igs.mha"}},
                    Shape{"TwoFilesRaw", "x.igs.mhd", PixelForm::kRaw, {"x.igs.mhd", "x.igs.raw"}},
                    Shape{"TwoFilesPacked", "x.igs.mhd", PixelForm::kZlib, {"x.igs.mhd", "x.igs.zraw"}}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_F(RecorderTest, WritesFilesForTheirOwnerAlone) {
  begin({.path = path_});
  put(0);
  wait_for([this] { return files().size() == 3; });  // with the lock
  const auto mode = [this](const std::string& name) {
    return std::filesystem::status(folder_ / name).permissions();
  };
  for (const std::string& name : files()) EXPECT_EQ(mode(name), std::filesystem::perms(0600)) << name;
  end();
  EXPECT_EQ(mode("sweeps.igs.mha"), std::filesystem::perms(0600));
}

TEST_F(RecorderTest, HasItsOpenSegmentSynced) {
  begin({.path = path_});
  put(0);
  wait_for([this] { return files().size() == 3; });
  const auto pixels = std::filesystem::canonical(folder_ / "sweeps.igs.mha.rec-0001.pixels");
  EXPECT_EQ(open_of(pixels), 2U) << "by the writer, and by SegmentSync";
  end();
}

TEST_F(RecorderTest, WritesTheFieldsOfPlus) {
  source_.counts_volumes = false;
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 3; ++i) put(i);
  end();
  const std::string text = text_of(path_);
  for (const char* const line :
       {"\nDimSize = 6 4 3\n", "\nKinds = domain domain list\n", "\nUltrasoundImageOrientation = MF\n",
        "\nSeq_Frame0002_Timestamp = 0.020000000\n", "\nSeq_Frame0002_ImageStatus = OK\n",
        "\nSeq_Frame0002_ImageToReferenceTransformStatus = OK\n", "\nFanlightSweepsNumbered = False\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
  EXPECT_EQ(text.find("VolumeIndex"), std::string::npos);
  EXPECT_EQ(text.find("SweepDirection"), std::string::npos);
}

/// ImageToReferenceTransform must lead where the geometry does.
TEST_F(RecorderTest, WritesPosesOfTheGeometry) {
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 3; ++i) put(i);
  end();
  const std::string text = text_of(path_);
  const std::string name = "\nSeq_Frame0001_ImageToReferenceTransform = ";
  std::array<double, 16> matrix{};
  std::istringstream numbers(text.substr(text.find(name) + name.size()));
  for (double& each : matrix) ASSERT_TRUE(numbers >> each);
  const FanGeometry of = geometry();
  const PlanePoint in_plane = of.plane_point({4, 3});
  const Point wanted = of.point(in_plane.x_mm, {stamp(1).angle_rad, in_plane.depth_mm});
  const auto row = [&matrix](std::size_t i) {
    return matrix[4 * i] * 4 + matrix[4 * i + 1] * 3 + matrix[4 * i + 3];
  };
  EXPECT_NEAR(row(0), wanted.x_mm, 1e-12);
  EXPECT_NEAR(row(1), wanted.y_mm, 1e-12);
  EXPECT_NEAR(row(2), wanted.z_mm, 1e-12);
}

TEST_F(RecorderTest, BeginsAFurtherFileWhereTheGeometryChanges) {
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 4; ++i) put(i);
  for (std::uint64_t i = 4; i < 8; ++i) {
    FrameStamp deeper = stamp(i);
    deeper.geometry_revision = 1;
    put(deeper, geometry(9), pixels(i, 9));
  }
  end();
  EXPECT_EQ(files(), (std::set<std::string>{"sweeps.igs.mha", "sweeps-2.igs.mha"}));
  EXPECT_EQ(status_.finished, 2U);
  EXPECT_EQ(status_.frames, 8U);
  EXPECT_EQ(open(path_).summary().rows, kRows);
  const Recording second = open(folder_ / "sweeps-2.igs.mha");
  EXPECT_EQ(second.summary().rows, 9U);
  EXPECT_EQ(second.frame_pixels(0)[0], 5);
}

TEST_F(RecorderTest, EndsAtItsLimits) {
  begin({.path = path_, .most_s = 0.035});
  for (std::uint64_t i = 0; i < 20; ++i) put(i);
  wait_for([this] { return status_.finished == 1; });
  EXPECT_EQ(status_.last_frames, 5U);  // 0 to 0.04 s
  EXPECT_EQ(status_.last_file_first_sequence, stamp(0).sequence);
  EXPECT_EQ(status_.last_file_last_sequence, stamp(4).sequence);
  EXPECT_EQ(status_.state, State::kIdle);
  EXPECT_FALSE(recorder_->tap().is_open());
  begin({.path = folder_ / "small.igs.mha", .most_bytes = 3 * kColumns * kRows + 5});
  for (std::uint64_t i = 0; i < 20; ++i) put(i);
  wait_for([this] { return status_.finished == 2; });
  EXPECT_EQ(status_.last_frames, 3U);
}

TEST_F(RecorderTest, KeepsTheLastSecondsOfARing) {
  begin({.path = path_, .ring_s = 2});
  for (std::uint64_t i = 0; i < 1000; ++i) put(i);  // 10 s
  wait_for([this] { return status_.frames == 1000; });
  // Segments of a second: those of the ring, one that is partly in it, and the open one.
  EXPECT_LE(files().size(), 2 * 4U + 1);
  finish();
  wait_for([this] { return status_.finished == 1; });
  const Recording kept = open(path_);
  EXPECT_EQ(kept.summary().frames, 201U);
  EXPECT_EQ(kept.frame_pixels(200)[0], static_cast<std::uint8_t>(1000));
  EXPECT_EQ(files(), std::set<std::string>{"sweeps.igs.mha"});
}

TEST_F(RecorderTest, KeepsARingUnderAnotherNameAndGoesOn) {
  begin({.path = folder_ / "ring.igs.mha", .ring_s = 2});
  for (std::uint64_t i = 0; i < 300; ++i) put(i);
  begin({.end_path = path_, .path = folder_ / "ring-b.igs.mha", .ring_s = 2});
  for (std::uint64_t i = 300; i < 310; ++i) put(i);
  wait_for([this] { return status_.finished == 1 && status_.frames == 10; });
  EXPECT_EQ(status_.last_file_first_sequence, stamp(99).sequence) << "of the last two seconds";
  EXPECT_EQ(status_.last_file_last_sequence, stamp(299).sequence);
  EXPECT_EQ(status_.first_sequence, stamp(300).sequence) << "of what is under way";
  EXPECT_EQ(status_.last_file, path_.string());
  EXPECT_TRUE(status_.ring);
  EXPECT_EQ(open(path_).summary().frames, 201U);
  EXPECT_EQ(files(), (std::set<std::string>{"sweeps.igs.mha", "ring-b.igs.mha.rec-0001.frames",
                                            "ring-b.igs.mha.rec-0001.pixels", "ring-b.igs.mha.rec-lock"}));
}

/// Orders that come while the disk keeps the recorder busy are carried out one after the other.
TEST_F(RecorderTest, CarriesOutEveryOrder) {
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 5; ++i) put(i);
  const RecordingLink link = recorder_->link();
  ASSERT_TRUE(link.send({.number = 2, .wish = RecordingOrder::Wish::kEnd}));
  ASSERT_TRUE(link.send(
      {.number = 3, .wish = RecordingOrder::Wish::kRecord, .drops = true, .path = folder_ / "next.igs.mha"}));
  wait_for([this] { return status_.order_done == 3 && status_.finished == 1; });
  EXPECT_EQ(open(path_).summary().frames, 5U);
}

TEST_F(RecorderTest, DropsARingAloneNeverARecording) {
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 5; ++i) put(i);
  begin({.drops = true, .path = folder_ / "next.igs.mha"});
  wait_for([this] { return status_.finished == 1; });
  EXPECT_EQ(open(path_).summary().frames, 5U);
}

TEST_F(RecorderTest, TakesTheNextFreeNumberForAFurtherFile) {
  std::ofstream(folder_ / "sweeps-2.igs.mha") << "someone's";
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 3; ++i) put(i);
  for (std::uint64_t i = 3; i < 6; ++i) {
    FrameStamp deeper = stamp(i);
    deeper.geometry_revision = 1;
    put(deeper, geometry(9), pixels(i, 9));
  }
  end();
  EXPECT_EQ(text_of(folder_ / "sweeps-2.igs.mha"), "someone's");
  EXPECT_EQ(open(folder_ / "sweeps-3.igs.mha").summary().frames, 3U);
}

TEST_F(RecorderTest, FindsNamesThatFollowFromOneThatIsTaken) {
  EXPECT_TRUE(check_free_name(path_));
  for (const char* const taken : {"sweeps.igs.mha", "sweeps.igs.mhd", "sweeps.igs.raw", "sweeps.igs.zraw",
                                  "sweeps.igs.mha.pictures.jsonl", "sweeps.igs.mha.measurements.json",
                                  "sweeps.igs.mha.rec-0003.frames"}) {
    std::ofstream(folder_ / taken) << "x";
    EXPECT_FALSE(check_free_name(path_)) << taken;
    std::filesystem::remove(folder_ / taken);
  }
}

TEST_F(RecorderTest, BeginsARingAnewWhereTheGeometryChanges) {
  begin({.path = path_, .ring_s = 2});
  for (std::uint64_t i = 0; i < 250; ++i) put(i);
  for (std::uint64_t i = 250; i < 260; ++i) {
    FrameStamp deeper = stamp(i);
    deeper.geometry_revision = 1;
    put(deeper, geometry(9), pixels(i, 9));
  }
  finish();
  wait_for([this] { return status_.finished == 1; });
  EXPECT_EQ(open(path_).summary().frames, 10U);
  EXPECT_EQ(files(), std::set<std::string>{"sweeps.igs.mha"});
}

TEST_F(RecorderTest, RemovesADroppedRecording) {
  begin({.path = path_, .ring_s = 2});
  for (std::uint64_t i = 0; i < 400; ++i) put(i);
  tell({.drops = true}, RecordingOrder::Wish::kEnd);
  EXPECT_EQ(status_.state, State::kIdle);
  EXPECT_TRUE(files().empty());
}

TEST_F(RecorderTest, BeginsAgainWhenThereIsRoom) {
  constexpr std::uint32_t kManyRows = 100;
  source_.geometry = geometry(kManyRows);
  const auto put_large = [this](std::uint64_t i) {
    put(stamp(i), geometry(kManyRows), pixels(i, kManyRows));
  };
  {
    const FileSizeLimit full(2000);  // three frames, and no header
    begin({.path = folder_ / "x.igs.mhd"});
    for (std::uint64_t i = 0; i < 10; ++i) put_large(i);
    wait_for_state(State::kNoRoom);
    EXPECT_NE(status_.trouble.find("could not be written"), std::string::npos) << status_.trouble;
    wait_for([this] { return status_.finished == 1; });
    EXPECT_TRUE(recorder_->tap().is_open()) << "what comes is counted";
  }
  wait_for(
      [this] { return status_.state == State::kRecording && status_.finished == 2; });  // within a second
  for (std::uint64_t i = 10; i < 20; ++i) put_large(i);
  end();
  EXPECT_EQ(status_.frames, 13U);
  EXPECT_EQ(status_.frames_missed, 7U);
  // There was no room for the header of the first file: it is written now.
  EXPECT_EQ(open(folder_ / "x-2.igs.mhd").summary().frames, 10U);
  EXPECT_EQ(open(folder_ / "x.igs.mhd").summary().frames, 3U);
  EXPECT_EQ(files(), (std::set<std::string>{"x.igs.mhd", "x.igs.raw", "x-2.igs.mhd", "x-2.igs.raw"}));
}

TEST_F(RecorderTest, KeepsOrCountsEachFrame) {
  constexpr std::uint64_t kFrames = 400;
  {
    const FileSizeLimit full(5'000);  // of records, before that of pixels
    begin({.path = path_});
    for (std::uint64_t i = 0; i < kFrames / 2; ++i) {
      put(i);
      // Several flushes succeed before one does not.
      if (i % 20 == 19) std::this_thread::sleep_for(std::chrono::nanoseconds(Recorder::kFlushNs));
    }
    wait_for([this] { return status_.frames_missed > 0; });
  }
  wait_for([this] { return status_.state == State::kRecording && status_.unfinished == 0; });
  for (std::uint64_t i = kFrames / 2; i < kFrames; ++i) put(i);
  end();
  EXPECT_EQ(status_.frames + status_.frames_missed, kFrames);
  EXPECT_GT(status_.frames_missed, 0U);
  std::uint64_t kept = 0;
  for (const std::string& file : files()) {
    if (file.ends_with(".raw")) continue;  // of a pair, which is written where there is no room for a copy
    const auto opened = open_recording_file(folder_ / file, 1'000'000);
    ASSERT_TRUE(opened) << opened.error().message;
    kept += opened->sequence.frames.size();
  }
  EXPECT_EQ(kept, status_.frames);
}

TEST_F(RecorderTest, WaitsWhereTheReserveOfTheDiskBegins) {
  recorder_ = std::make_unique<Recorder>(
      source_, bell_, Recorder::Config{.folder = folder_.path(), .reserve_bytes = std::uint64_t{1} << 60});
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 5; ++i) put(i);
  wait_for_state(State::kNoRoom);
  EXPECT_NE(status_.trouble.find("GB that recordings leave free"), std::string::npos) << status_.trouble;
  for (std::uint64_t i = 5; i < 9; ++i) put(i);
  end();
  EXPECT_EQ(status_.frames + status_.frames_missed, 9U);
  EXPECT_GE(status_.frames_missed, 4U);
  if (status_.frames < 2) return;  // a single frame is no sweep
  EXPECT_EQ(open(path_).summary().frames, status_.frames) << "what was written is kept";
}

TEST_F(RecorderTest, WaitsWhereTheQuotaIsUsedUp) {
  std::ofstream(folder_ / "older.igs.mha") << std::string(2000, 'x');
  recorder_ = std::make_unique<Recorder>(source_, bell_,
                                         Recorder::Config{.folder = folder_.path(), .quota_bytes = 2500});
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 40; ++i) put(i);
  wait_for_state(State::kNoRoom);
  EXPECT_NE(status_.trouble.find("the recordings take"), std::string::npos) << status_.trouble;
  end();
  EXPECT_EQ(status_.frames + status_.frames_missed, 40U);
}

TEST_F(RecorderTest, ShortensARingToItsQuota) {
  constexpr std::uint64_t kQuotaBytes = 300'000;
  constexpr std::uint32_t kManyRows = 100;
  source_.geometry = geometry(kManyRows);
  recorder_ = std::make_unique<Recorder>(
      source_, bell_, Recorder::Config{.folder = folder_.path(), .quota_bytes = kQuotaBytes});
  begin({.path = path_, .ring_s = 10});
  constexpr std::uint64_t kFrames = 1200;  // 12 s, of 656 bytes each with its record
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    put(stamp(i), geometry(kManyRows), pixels(i, kManyRows));
    if (i % 100 == 99) std::this_thread::sleep_for(std::chrono::nanoseconds(Recorder::kFlushNs));
  }
  wait_for([this] { return status_.frames == kFrames; });
  EXPECT_EQ(status_.state, State::kRecording) << status_.trouble;
  EXPECT_EQ(status_.frames_missed, 0U);
  finish();
  wait_for([this] { return status_.finished == 1; });
  const auto frames = open(path_).summary().frames;
  EXPECT_GT(frames, 200U);
  EXPECT_LT(frames, 700U) << "instead of the 1000 of ten seconds";
}

TEST_F(RecorderTest, ReplacesAnAngleThatIsNoNumber) {
  begin({.path = path_});
  for (std::uint64_t i = 0; i < 3; ++i) put(i);
  FrameStamp wrong = stamp(3);
  wrong.angle_rad = std::nan("");
  put(wrong, geometry(), pixels(3));
  end();
  EXPECT_EQ(open(path_).stream()->frames[3].fault, FrameFault::kInvalid);
}

TEST(FileOfRecordingTest, NumbersFurtherFiles) {
  EXPECT_EQ(file_of_recording("a/x.igs.mha", 1), "a/x.igs.mha");
  EXPECT_EQ(file_of_recording("a/x.igs.mha", 2), "a/x-2.igs.mha");
  EXPECT_EQ(file_of_recording("x.y.mhd", 3), "x.y-3.mhd");
}

}  // namespace
}  // namespace fanlight::test
