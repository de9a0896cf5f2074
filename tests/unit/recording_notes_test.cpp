// SPDX-License-Identifier: Apache-2.0
// What a recording tells about itself: what is assumed, what was noticed, and what it is instead of a fan.
#include <fmt/format.h>

#include <numeric>

#include "tests/unit/recording_fixture.hpp"

namespace fanlight {
namespace {

using test::NamedFile;
using test::RecordingTest;
using test::write_file;

bool has_note(const Recording& recording, std::string_view words) {
  return std::ranges::any_of(recording.summary().notes, [words](const std::string& note) {
    return note.find(words) != std::string::npos;
  });
}

std::string refusal(const Result<Recording>& recording) {
  return recording ? std::string("it was taken") : recording.error().message;
}

TEST_F(RecordingTest, HasNoNotesWhereAllIsAsUsual) {
  EXPECT_EQ(open_whole(test::fan_recording(12, 2, 20)).summary().notes, std::vector<std::string>());
}

TEST_F(RecordingTest, LeavesOutAFrameWithAWrongAngle) {
  NamedFile file = test::fan_recording(30, 2, 20);
  NamedFile::set(file.frames[11], "MotorAngleDeg", "60");
  const Recording recording = open_whole(file);
  EXPECT_FALSE(recording.frames()[11].valid);
  EXPECT_EQ(recording.summary().frames_invalid, 1U);
  EXPECT_EQ(recording.summary().angle_outliers, 1U);
  EXPECT_NEAR(recording.summary().largest_angle_deg, 20, 1e-9);
  EXPECT_TRUE(has_note(recording, "1 of 60 frames are left out"));
}

TEST_F(RecordingTest, AWrongAngleIsNoTurningPoint) {
  NamedFile file = test::fan_recording(30, 2, 20);
  file.remove_all("VolumeIndex");
  NamedFile::set(file.frames[11], "MotorAngleDeg", "60");
  const Recording recording = open_whole(file);
  EXPECT_EQ(recording.sweeps().size(), 2U);
  EXPECT_FALSE(recording.frames()[11].valid);
}

TEST_F(RecordingTest, SaysThatSpreadAnglesAreAssumed) {
  NamedFile file = test::fan_recording(12, 1, 20);
  file.remove_all("MotorAngleDeg");
  file.header.emplace_back("FanlightFirstAngleDeg", "-30");
  file.header.emplace_back("FanlightLastAngleDeg", "30");
  const Recording recording = open_whole(file);
  EXPECT_TRUE(has_note(recording, "The motor angles are assumed"));
  EXPECT_TRUE(has_note(recording, "from -30 to 30 deg"));
}

TEST_F(RecordingTest, SaysThatTheAnglesOfTheGeometryAreNotUsed) {
  NamedFile file = test::fan_recording(12, 1, 20);
  file.header.emplace_back("FanlightFirstAngleDeg", "-30");
  EXPECT_TRUE(has_note(open_whole(file), "are not used"));
}

TEST_F(RecordingTest, AsksWhetherTheAnglesAreRadians) {
  EXPECT_TRUE(has_note(open_whole(test::fan_recording(12, 1, 0.6)), "are these radians?"));
}

TEST_F(RecordingTest, TakesTheAnglesWhereTheStatedDirectionContradictsThem) {
  NamedFile file = test::fan_recording(12, 2, 20);
  file.set_all("SweepDirection", "BACKWARD");
  const Recording recording = open_whole(file);
  EXPECT_EQ(recording.sweeps()[0].direction, SweepDirection::kForward);
  EXPECT_EQ(recording.sweeps()[1].direction, SweepDirection::kBackward);
  EXPECT_TRUE(has_note(recording, "The SweepDirection of 1 of 2 sweeps contradicts"));
}

TEST_F(RecordingTest, TakesTheStatedDirectionOfASingleFrame) {
  NamedFile file = test::fan_recording(12, 2, 20);
  file.set_all("SweepDirection", "BACKWARD");
  for (std::size_t i = 0; i < 11; ++i) file.set(file.frames[i], "ImageStatus", "INVALID");
  const Recording recording = open_whole(file);
  EXPECT_EQ(recording.sweeps()[0].direction, SweepDirection::kBackward);
  EXPECT_FALSE(has_note(recording, "contradicts"));
}

TEST_F(RecordingTest, RefusesASweepAFrame) {
  NamedFile file = test::fan_recording(12, 1, 20);
  for (std::size_t i = 0; i < file.frames.size(); ++i)
    NamedFile::set(file.frames[i], "VolumeIndex", fmt::format("{}", i));
  EXPECT_NE(refusal(open(file.bytes())).find("each frame has a VolumeIndex of its own"), std::string::npos);
}

TEST_F(RecordingTest, SaysThatAProbeWasTrackedByHand) {
  NamedFile file = test::fan_recording(12, 1, 20);
  file.remove_all("MotorAngleDeg");
  for (std::size_t i = 0; i < file.frames.size(); ++i) {
    NamedFile::set(file.frames[i], "ProbeToTrackerTransform",
                   fmt::format("1 0 0 {} 0 1 0 0 0 0 1 0 0 0 0 1", 3 * i + 5));
  }
  const std::string sentence = refusal(open(file.bytes()));
  EXPECT_NE(sentence.find(
                "the probe was moved, 33 mm and 0 deg far by its ProbeToTrackerTransform, and did not turn"),
            std::string::npos)
      << sentence;
  // The angles count, whatever else is in the file.
  for (std::size_t i = 0; i < file.frames.size(); ++i)
    NamedFile::set(file.frames[i], "MotorAngleDeg", fmt::format("{}", i));
  EXPECT_TRUE(open(file.bytes()));
}

TEST_F(RecordingTest, TellsHowFarAProbeTurned) {
  NamedFile file = test::fan_recording(2, 1, 20);
  file.remove_all("MotorAngleDeg");
  NamedFile::set(file.frames[0], "ProbeToTrackerTransform", "2 0 0 0 0 2 0 0 0 0 1 0 0 0 0 1");
  NamedFile::set(file.frames[1], "ProbeToTrackerTransform", "0 -2 0 0 2 0 0 0 0 0 1 0 0 0 0 1");
  EXPECT_NE(refusal(open(file.bytes())).find("0 mm and 90 deg far"), std::string::npos);
}

TEST_F(RecordingTest, AGeometryMayNameTheFramesThatItIsFor) {
  write_file(folder_ / "sweep.igs.mha.toml", "columns = 8\nrows = 6\nframes = 12\n");
  EXPECT_TRUE(open(test::fan_recording(12, 1, 20).bytes()));
  write_file(folder_ / "sweep.igs.mha.toml", "columns = 6\nrows = 8\n");
  const std::string sentence = refusal(open(test::fan_recording(12, 1, 20).bytes()));
  EXPECT_NE(sentence.find("has 12 frames of 8 columns and 6 rows, expected any number of frames of 6 columns "
                          "and 8 rows, which its geometry is for"),
            std::string::npos)
      << sentence;
}

/// Frames of a disc, whose lines are alike from one to the next.
NamedFile disc_recording(std::uint32_t columns, std::uint32_t rows) {
  NamedFile file = test::fan_recording(6, 1, 20);
  file.columns = columns;
  file.rows = rows;
  file.pixels.clear();
  for (std::size_t frame = 0; frame < file.frames.size(); ++frame) {
    for (std::uint32_t row = 0; row < rows; ++row) {
      for (std::uint32_t column = 0; column < columns; ++column) {
        const double x = (column + 0.5) / columns - 0.5;
        const double y = (row + 0.5) / rows - 0.5;
        file.pixels.push_back(static_cast<std::uint8_t>(x * x + y * y < 0.1 ? 200 : 20));
      }
    }
  }
  return file;
}

TEST_F(RecordingTest, AsksWhetherTheSizeIsTransposed) {
  NamedFile file = disc_recording(96, 64);
  EXPECT_EQ(open_whole(file).summary().notes, std::vector<std::string>());
  std::swap(file.columns, file.rows);
  EXPECT_TRUE(has_note(open_whole(file), "are the first two numbers of DimSize exchanged?"));
}

TEST_F(RecordingTest, ReadsAHeaderWhoseSizeFollowsTheFrames) {
  std::string bytes = test::fan_recording(5, 2, 20).bytes();
  const auto line = bytes.find("DimSize");
  const std::string size = bytes.substr(line, bytes.find('\n', line) + 1 - line);
  bytes.erase(line, size.size());
  bytes.insert(bytes.find("ElementDataFile"), size);
  const auto recording = open(bytes);
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary().frames, 10U);
  EXPECT_NEAR(recording->summary().largest_angle_deg, 20, 1e-9);
}

TEST_F(RecordingTest, ReadsFramesFromFrontToBackAsItReadsThemAtOnce) {
  for (const bool compressed : {false, true}) {
    NamedFile file = test::fan_recording(5, 2, 20);
    file.compressed = compressed;
    std::iota(file.pixels.begin(), file.pixels.end(), std::uint8_t{0});
    for (const char* orientation : {"MFA", "FM", "UN"}) {
      NamedFile::set(file.header, "UltrasoundImageOrientation", orientation);
      const Recording whole = open_whole(file);
      auto forward =
          Recording::open({.path = path_, .geometry_path = {}, .pixels = Recording::Pixels::kFromFile});
      ASSERT_TRUE(forward) << forward.error().message;
      std::vector<std::uint8_t> pixels(whole.frame_pixels(0).size());
      for (const std::size_t frame : {0U, 1U, 2U, 5U, 9U}) {
        ASSERT_TRUE(forward->read_frame(frame, pixels));
        EXPECT_TRUE(std::ranges::equal(pixels, whole.frame_pixels(frame))) << orientation << " " << frame;
      }
    }
  }
}

TEST_F(RecordingTest, FramesLostByTheirNumberAreNoGap) {
  NamedFile file = test::fan_recording(74, 1, 37);
  for (const std::size_t lost : {3U, 3U, 3U}) {
    file.frames.erase(file.frames.begin() + static_cast<std::ptrdiff_t>(lost));
    file.pixels.resize(file.pixels.size() - std::size_t{file.columns} * file.rows);
  }
  const Recording recording = open_whole(file);
  EXPECT_EQ(recording.summary().angle_outliers, 0U);
  EXPECT_EQ(recording.summary().frames_lost, 3U);
}

TEST_F(RecordingTest, SweepsOfDifferentSpeedAreNoSpikes) {
  NamedFile file = test::fan_recording(70, 1, 30);
  file.remove_all("VolumeIndex");
  for (std::size_t i = 0; i < 70; ++i) {
    const double angle_deg =
        i < 60 ? static_cast<double>(i) - 30 : 29.0 - 6.0 * (static_cast<double>(i) - 59);
    NamedFile::set(file.frames[i], "MotorAngleDeg", fmt::format("{}", angle_deg));
  }
  const Recording recording = open_whole(file);
  EXPECT_EQ(recording.summary().angle_outliers, 0U);
  EXPECT_EQ(recording.sweeps().size(), 2U);
}

TEST_F(RecordingTest, FindsDamageWhenItComesToItWhereItReadsForward) {
  NamedFile file = test::fan_recording(5, 2, 20);
  for (std::size_t i = 0; i < file.pixels.size(); ++i)
    file.pixels[i] = static_cast<std::uint8_t>(1'664'525U * (i * i + 7) >> 11);
  std::string bytes = file.bytes();
  NamedFile::set(file.header, "CompressedDataSize", "100");
  bytes = file.bytes();
  write_file(path_, bytes);
  auto forward =
      Recording::open({.path = path_, .geometry_path = {}, .pixels = Recording::Pixels::kFromFile});
  ASSERT_TRUE(forward) << forward.error().message;
  std::vector<std::uint8_t> pixels(48);
  const auto read = forward->read_frame(9, pixels);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("damaged or cut off"), std::string::npos) << read.error().message;
}

}  // namespace
}  // namespace fanlight
