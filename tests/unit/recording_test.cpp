// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/recording_fixture.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include "tests/support/data_folder.hpp"

namespace fanlight {
namespace {

using test::NamedFile;
using test::RecordingTest;
using test::write_file;

TEST_F(RecordingTest, ReadsPlainAndCompressedFilesAlike) {
  for (const bool compressed : {false, true}) {
    NamedFile file = test::fan_recording(5, 2, 20);
    file.compressed = compressed;
    const Recording recording = open_whole(file);
    const RecordingSummary& summary = recording.summary();
    EXPECT_EQ(summary.compressed, compressed);
    EXPECT_EQ(summary.frames, 10U);
    EXPECT_EQ(summary.columns, 8U);
    EXPECT_EQ(summary.rows, 6U);
    EXPECT_EQ(summary.sweeps, 2U);
    EXPECT_EQ(summary.frames_in_longest_sweep, 5U);
    EXPECT_EQ(summary.frames_invalid, 0U);
    EXPECT_EQ(summary.frames_lost, 0U);
    EXPECT_NEAR(summary.smallest_angle_deg, -20, 1e-9);
    EXPECT_NEAR(summary.largest_angle_deg, 20, 1e-9);
    EXPECT_NEAR(summary.duration_s, 0.9, 1e-6);
    EXPECT_NEAR(summary.frame_rate_hz, 10, 1e-3);
    EXPECT_EQ(summary.geometry.motor_radius_mm, 28);
    for (std::size_t i = 0; i < 10; ++i) {
      EXPECT_TRUE(
          std::ranges::all_of(recording.frame_pixels(i), [i](std::uint8_t grey) { return grey == i + 1; }));
    }
  }
}

TEST_F(RecordingTest, DirectionsFollowTheAngles) {
  const Recording recording = open_whole(test::fan_recording(5, 3, 20));
  ASSERT_EQ(recording.sweeps().size(), 3U);
  EXPECT_EQ(recording.sweeps()[0].direction, SweepDirection::kForward);
  EXPECT_EQ(recording.sweeps()[1].direction, SweepDirection::kBackward);
  EXPECT_EQ(recording.sweeps()[2].direction, SweepDirection::kForward);
}

TEST_F(RecordingTest, WithoutVolumeIndexSweepsEndWhereTheAngleTurns) {
  NamedFile file = test::fan_recording(9, 4, 20);
  file.remove_all("VolumeIndex");
  const Recording recording = open_whole(file);
  ASSERT_EQ(recording.sweeps().size(), 4U);
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(recording.sweeps()[i].first_frame, 9 * i);
    EXPECT_EQ(recording.sweeps()[i].frames, 9U);
    EXPECT_EQ(recording.sweeps()[i].volume_index, i);
    EXPECT_EQ(recording.sweeps()[i].direction,
              i % 2 == 0 ? SweepDirection::kForward : SweepDirection::kBackward);
  }
}

TEST_F(RecordingTest, AHandThatWaversMakesNoTurningPoint) {
  NamedFile file = test::fan_recording(9, 1, 20);
  file.remove_all("VolumeIndex");
  const double angles_deg[] = {-20, -20, -19, -19.6, -10, -10.9, 0, 5, 20};
  for (std::size_t i = 0; i < 9; ++i)
    NamedFile::set(file.frames[i], "MotorAngleDeg", fmt::format("{}", angles_deg[i]));
  EXPECT_EQ(open_whole(file).sweeps().size(), 1U);
}

TEST_F(RecordingTest, CountsWhatWasLostWhenItWasMade) {
  NamedFile file = test::fan_recording(5, 2, 20);
  NamedFile::set(file.frames[4], "FrameIndex", "7");
  const Recording recording = open_whole(file);
  EXPECT_EQ(recording.summary().frames_lost, 3U);
  EXPECT_EQ(recording.frames()[4].lost_before, 3U);
  EXPECT_EQ(recording.frames()[5].lost_before, 0U) << "another sweep counts again";
}

TEST_F(RecordingTest, InvalidFramesNeedNoAngle) {
  NamedFile file = test::fan_recording(5, 1, 20);
  NamedFile::set(file.frames[2], "ImageStatus", "INVALID");
  NamedFile::remove(file.frames[2], "MotorAngleDeg");
  const Recording recording = open_whole(file);
  EXPECT_EQ(recording.summary().frames_invalid, 1U);
  EXPECT_FALSE(recording.frames()[2].valid);
}

TEST_F(RecordingTest, SpreadsTheAnglesOfARecordingWithoutThem) {
  NamedFile file = test::fan_recording(5, 2, 20);
  file.remove_all("MotorAngleDeg");
  file.header.emplace_back("FanlightFirstAngleDeg", "-30");
  file.header.emplace_back("FanlightLastAngleDeg", "30");
  for (std::size_t i = 5; i < 10; ++i) NamedFile::set(file.frames[i], "SweepDirection", "BACKWARD");
  const Recording recording = open_whole(file);
  for (std::size_t i = 0; i < 10; ++i) {
    const double expected_deg =
        i < 5 ? -30 + 15.0 * static_cast<double>(i) : 30 - 15.0 * static_cast<double>(i - 5);
    EXPECT_NEAR(degrees(recording.frames()[i].angle_rad), expected_deg, 1e-9);
  }
  EXPECT_EQ(recording.sweeps()[1].direction, SweepDirection::kBackward);
}

/// A recording with a radius of its own, pixels from its transform, and a file beside it that gives other
/// values.
class ContradictedRecordingTest : public RecordingTest {
 protected:
  ContradictedRecordingTest() {
    NamedFile::remove(file_.header, "FanlightPixelWidthMm");
    NamedFile::remove(file_.header, "FanlightPixelHeightMm");
    NamedFile::remove(file_.header, "FanlightFaceRow");
    file_.set_all("ImageToReferenceTransform", "0 0.4 0 7 0.3 0 0 8 0 0 1 9 0 0 0 1");
    write_file(folder_ / "sweep.igs.mha.toml", kBeside);
  }

  static std::string origin(const Recording& recording, std::string_view key) {
    const auto& values = recording.summary().geometry_values;
    return std::ranges::find(values, key, &RecordingGeometry::Value::key)->origin;
  }
  static bool notes(const Recording& recording, std::string_view text) {
    return std::ranges::any_of(recording.summary().notes,
                               [&](const std::string& note) { return note.find(text) != note.npos; });
  }

  static constexpr const char* kBeside =
      "motor_radius_mm = 31\npixel_height_mm = 0.25 # finer\nface_row = 2\n";
  NamedFile file_ = test::fan_recording(5, 1, 20);
};

TEST_F(ContradictedRecordingTest, ItsOwnValuesCountMoreThanTheFileBesideIt) {
  const Recording recording = open_whole(file_);
  const FanGeometry& geometry = recording.summary().geometry;
  EXPECT_DOUBLE_EQ(geometry.motor_radius_mm, 28);
  EXPECT_DOUBLE_EQ(geometry.pixel_height_mm, 0.4);
  EXPECT_DOUBLE_EQ(geometry.pixel_width_mm, 0.3);
  EXPECT_DOUBLE_EQ(geometry.face_column, 3.5);
  EXPECT_DOUBLE_EQ(geometry.face_row, 2);
  EXPECT_EQ(origin(recording, "motor_radius_mm"), "the header");
  EXPECT_EQ(origin(recording, "pixel_width_mm"), "its ImageToReferenceTransform");
  EXPECT_EQ(origin(recording, "face_row"), path_.string() + ".toml");
  EXPECT_TRUE(
      notes(recording, "There are two values of motor_radius_mm: 28 from the header is used, and not 31"));
  EXPECT_TRUE(
      notes(recording, "two values of pixel_height_mm: 0.4 from its ImageToReferenceTransform is used"));
  EXPECT_FALSE(notes(recording, "two values of face_row"));
}

TEST_F(ContradictedRecordingTest, AFileThatIsGivenCountsMost) {
  write_file(folder_ / "given.toml", kBeside);
  write_file(path_, file_.bytes());
  const auto recording = Recording::open({.path = path_, .geometry_path = folder_ / "given.toml"});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_DOUBLE_EQ(recording->summary().geometry.motor_radius_mm, 31);
  EXPECT_DOUBLE_EQ(recording->summary().geometry.pixel_height_mm, 0.25);
  EXPECT_TRUE(notes(*recording, "There are two values of motor_radius_mm: 31 from"));
}

TEST_F(ContradictedRecordingTest, ATransformThatWasNeverSetCountsLeast) {
  file_.set_all("ImageToReferenceTransform", "0 1 0 5 1 0 0 7 0 0 1 0 0 0 0 1");
  const Recording recording = open_whole(file_);
  EXPECT_DOUBLE_EQ(recording.summary().geometry.pixel_height_mm, 0.25);
  EXPECT_DOUBLE_EQ(recording.summary().geometry.pixel_width_mm, 1);
}

TEST_F(RecordingTest, AnEqualLineTwiceIsNoContradiction) {
  NamedFile file = test::fan_recording(5, 1, 20);
  file.header.push_back(file.header.back());
  file.frames[1].push_back(file.frames[1].back());
  EXPECT_EQ(open_whole(file).summary().frames, 5U);
}

TEST_F(RecordingTest, AnglesThatLookLikeRadiansAreNamed) {
  NamedFile file = test::fan_recording(5, 1, 20);
  write_file(folder_ / "sweep.igs.mha.toml", "sector_half_angle_deg = 0.61\nprobe_radius_mm = 40\n");
  const Recording recording = open_whole(file);
  EXPECT_TRUE(std::ranges::any_of(recording.summary().notes, [](const std::string& note) {
    return note ==
           "With sector_half_angle_deg = 0.61 the frames span 1.22 deg. Is it in radians? 34.9504 deg would "
           "span 69.9 deg.";
  }));
}

/// A recording of a curved array with a scan line in each row of the file, the first line at the marked side.
NamedFile convex_recording() {
  NamedFile file = test::fan_recording(5, 1, 20);
  for (const auto* const field : {"FanlightPixelWidthMm", "FanlightPixelHeightMm"}) {
    NamedFile::remove(file.header, field);
  }
  NamedFile::set(file.header, "UltrasoundImageOrientation", "FU");
  NamedFile::set(file.header, "FanlightFrameKind", "convex-lines");
  NamedFile::set(file.header, "FanlightLinePitchDeg", "1.5");
  NamedFile::set(file.header, "FanlightProbeRadiusMm", "40");
  NamedFile::set(file.header, "FanlightPixelHeightMm", "0.5");
  return file;
}

TEST_F(RecordingTest, ReadsScanLinesStoredInRows) {
  for (const bool compressed : {false, true}) {
    NamedFile file = convex_recording();
    file.compressed = compressed;
    for (std::size_t i = 0; i < file.pixels.size(); ++i) {
      file.pixels[i] = static_cast<std::uint8_t>(10 * (i / file.columns % file.rows) + i % file.columns);
    }
    const Recording recording = open_whole(file);
    EXPECT_EQ(recording.summary().columns, 6U);
    EXPECT_EQ(recording.summary().rows, 8U);
    for (std::size_t frame = 0; frame < 5; ++frame) {
      for (std::uint32_t row = 0; row < 8; ++row) {
        for (std::uint32_t column = 0; column < 6; ++column) {
          ASSERT_EQ(recording.frame_pixels(frame)[row * 6 + column], 10 * (5 - column) + row);
        }
      }
    }
  }
}

TEST_F(RecordingTest, TakesTheGeometryOfConvexLines) {
  NamedFile file = convex_recording();
  // Meaningless for diverging lines.
  file.set_all("ImageToReferenceTransform", "0 0.4 0 7 0.3 0 0 8 0 0 1 9 0 0 0 1");
  NamedFile::set(file.header, "FanlightSectorHalfAngleDeg", "30");
  const Recording recording = open_whole(file);
  const FanGeometry& geometry = recording.summary().geometry;
  EXPECT_EQ(geometry.kind, FrameKind::kConvexLines);
  EXPECT_EQ(geometry.columns, 6U);
  EXPECT_EQ(geometry.rows, 8U);
  EXPECT_EQ(geometry.line_pitch_deg, 1.5);
  EXPECT_EQ(geometry.probe_radius_mm, 40);
  EXPECT_EQ(geometry.pixel_height_mm, 0.5);
  EXPECT_EQ(geometry.sector, FanGeometry::Sector{});
  std::map<std::string_view, std::string> shown;
  for (const auto& value : recording.summary().geometry_values) shown.emplace(value.key, value.value);
  EXPECT_EQ(shown["frame_kind"], "convex-lines");
  EXPECT_EQ(shown["line_pitch_deg"], "1.5");
  EXPECT_FALSE(shown.contains("pixel_width_mm")) << "nothing is shown that is not read";
  EXPECT_FALSE(shown.contains("sector_half_angle_deg"));
}

TEST_F(RecordingTest, ConvexLinesNeedTheirPitchAndRadiusAndNoTransform) {
  NamedFile file = convex_recording();
  file.set_all("ImageToReferenceTransform", "0.3 0 0 7 0 0.4 0 8 0 0 1 9 0 0 0 1");
  for (const auto* const field : {"FanlightProbeRadiusMm", "FanlightLinePitchDeg", "FanlightPixelHeightMm"}) {
    NamedFile::remove(file.header, field);
  }
  const auto refused = open(file.bytes());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            path_.string() +
                ": the fan geometry lacks pixel_height_mm, probe_radius_mm, line_pitch_deg, expected a value "
                "for each in sweep.igs.mha.toml, in a file given by --geometry, or in the header as "
                "FanlightPixelHeightMm, FanlightProbeRadiusMm, FanlightLinePitchDeg");
}

TEST_F(RecordingTest, ALinePitchContradictsParallelColumns) {
  NamedFile file = convex_recording();
  NamedFile::remove(file.header, "FanlightFrameKind");
  const auto refused = open(file.bytes());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, path_.string() +
                                         ": the header gives a line_pitch_deg for cartesian frames, expected "
                                         "another frame_kind, or no line_pitch_deg");
}

TEST_F(RecordingTest, TheTransformOfTurnedImagesTurnsWithThem) {
  NamedFile file = test::fan_recording(5, 1, 20);
  NamedFile::remove(file.header, "FanlightPixelWidthMm");
  NamedFile::remove(file.header, "FanlightPixelHeightMm");
  NamedFile::set(file.header, "UltrasoundImageOrientation", "FMD");
  file.set_all("ImageToReferenceTransform", "0 0.4 0 7 0.3 0 0 8 0 0 1 9 0 0 0 1");
  write_file(folder_ / "sweep.igs.mha.toml", "frame_kind = \"linear-lines\"\n");
  const Recording recording = open_whole(file);
  const FanGeometry& geometry = recording.summary().geometry;
  EXPECT_EQ(geometry.kind, FrameKind::kLinearLines);
  EXPECT_DOUBLE_EQ(geometry.pixel_width_mm, 0.4);
  EXPECT_DOUBLE_EQ(geometry.pixel_height_mm, 0.3);
}

TEST_F(RecordingTest, FramesAreCartesianUnlessSomethingElseIsSaid) {
  const Recording recording = open_whole(test::fan_recording(5, 1, 20));
  EXPECT_EQ(recording.summary().geometry.kind, FrameKind::kCartesian);
  const auto& values = recording.summary().geometry_values;
  const auto kind = std::ranges::find(values, "frame_kind", &RecordingGeometry::Value::key);
  ASSERT_NE(kind, values.end());
  EXPECT_EQ(kind->value, "cartesian");
  EXPECT_EQ(kind->origin, "the default");
}

TEST_F(RecordingTest, AGeometryFileStandsInForTheOneBesideTheRecording) {
  write_file(path_, test::fan_recording(5, 1, 20).bytes());
  write_file(folder_ / "sweep.igs.mha.toml", "motor_radius_mm = 31\n");
  write_file(folder_ / "other.toml", "face_row = -2.5\nprobe_radius_mm = 50\nsector_half_angle_deg = 30\n");
  const auto recording = Recording::open({.path = path_, .geometry_path = folder_ / "other.toml"});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary().geometry.motor_radius_mm, 28);
  EXPECT_EQ(recording->summary().geometry.face_row, -2.5);
  EXPECT_EQ(recording->summary().geometry.probe_radius_mm, 50);
  EXPECT_EQ(recording->summary().geometry.sector.half_angle_deg, 30);
}

TEST_F(RecordingTest, NamesTheGeometryThatIsMissing) {
  NamedFile file = test::fan_recording(5, 1, 20);
  NamedFile::remove(file.header, "FanlightMotorRadiusMm");
  NamedFile::remove(file.header, "FanlightFaceRow");
  const auto refused = open(file.bytes());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            path_.string() +
                ": the fan geometry lacks face_row, motor_radius_mm, expected a value for each in "
                "sweep.igs.mha.toml, in a file given by --geometry, or in the header as FanlightFaceRow, "
                "FanlightMotorRadiusMm");
}

TEST_F(RecordingTest, RefusesGeometryFilesThatAreNone) {
  write_file(path_, test::fan_recording(5, 1, 20).bytes());
  const auto geometry = folder_ / "geometry.toml";
  const auto refusal = [&] {
    const auto recording = Recording::open({.path = path_, .geometry_path = geometry});
    return recording ? std::string("taken") : recording.error().message.substr(geometry.string().size() + 2);
  };
  EXPECT_EQ(refusal(), "there is no such file, expected a fan geometry in TOML");
  write_file(geometry, "motor_radius_mm = 31\nface_row = = 3\n");
  EXPECT_EQ(refusal(), "line 2 is not TOML, expected lines such as motor_radius_mm = 28.0");
  write_file(geometry, "motor_radius = 31\n");
  EXPECT_TRUE(refusal().starts_with("there is a key \"motor_radius\", expected pixel_width_mm, "))
      << refusal();
  write_file(geometry, "motor_radius_mm = \"31\"\n");
  EXPECT_EQ(refusal(), "motor_radius_mm is no number, expected a number");
  write_file(geometry, "motor_radius_mm = inf\n");
  EXPECT_EQ(refusal(), "motor_radius_mm is no number, expected a number");
  for (const auto* const kind : {"\"polar\"", "1", "[\"cartesian\"]"}) {
    write_file(geometry, fmt::format("frame_kind = {}\n", kind));
    EXPECT_EQ(refusal(),
              "frame_kind is none of its choices, expected cartesian, convex-lines or linear-lines");
  }
  write_file(geometry, "a = " + std::string(4000, '['));
  EXPECT_EQ(refusal(),
            "more than 16 brackets are open at once, expected lines such as motor_radius_mm = 28.0");
  std::string dotted = "a";
  while (dotted.size() < 4000) dotted += ".a";
  write_file(geometry, dotted + " = 1\n");
  EXPECT_EQ(refusal(), "a key has more than 16 parts, expected lines such as motor_radius_mm = 28.0");
  write_file(geometry, std::string(70'000, '#'));
  EXPECT_EQ(refusal(), "the file is longer than 65536 bytes, expected lines such as motor_radius_mm = 28.0");
  write_file(geometry, std::string("\x00\xff\x01", 3));
  EXPECT_NE(refusal(), "taken");
}

TEST_F(RecordingTest, ReadsTheLiverSweep) {
  const auto path = test::data_folder() / "liver_fan_sweep.igs.mha";
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << path << " is not there; set FANLIGHT_DATA to its folder";

  write_file(folder_ / "liver.toml", "face_column = 369\nface_row = 22.0\nmotor_radius_mm = 28\n");
  const auto recording = Recording::open({.path = path, .geometry_path = folder_ / "liver.toml"});
  ASSERT_TRUE(recording) << recording.error().message;
  const RecordingSummary& summary = recording->summary();
  EXPECT_EQ(summary.frames, 140U);
  EXPECT_EQ(summary.columns, 739U);
  EXPECT_EQ(summary.rows, 593U);
  EXPECT_EQ(summary.sweeps, 1U);
  EXPECT_TRUE(summary.compressed);
  EXPECT_NEAR(summary.largest_angle_deg - summary.smallest_angle_deg, 40.9, 0.05);
  EXPECT_NEAR(summary.frame_rate_hz, 22.8, 0.1);
  EXPECT_NEAR(summary.geometry.pixel_width_mm, 0.3148178, 1e-6);
  EXPECT_NEAR(summary.geometry.pixel_height_mm, 0.3148178, 1e-6);
  EXPECT_GT(*std::ranges::max_element(recording->frame_pixels(70)), 200);

  const auto without = Recording::open({.path = path, .geometry_path = {}});
  ASSERT_FALSE(without);
  EXPECT_NE(without.error().message.find("lacks face_column, face_row, motor_radius_mm"), std::string::npos);
}

}  // namespace
}  // namespace fanlight
