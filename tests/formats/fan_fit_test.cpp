// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/fan_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "acquisition/replay/recording.hpp"
#include "proto/model/fan_geometry.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

/// Poses of a fan about an axis `axis_mm` above row 0, in a room that is turned and far away.
std::vector<ImagePose> fan(double axis_mm, double tilt_deg, int frames, double shake_mm = 0) {
  std::vector<ImagePose> poses;
  const double turn = 0.7;
  for (int i = 0; i < frames; ++i) {
    const double angle = radians(tilt_deg) * (i / (frames - 1.0) - 0.5) + 0.3;
    const double shake = i % 2 == 0 ? shake_mm : -shake_mm;
    // In the fan's frame: along x, down (0, cos, sin), origin axis_mm below the axis.
    const std::array<std::array<double, 3>, 3> local = {
        {{0.5, 0, 0},
         {0, 0.4 * std::cos(angle), 0.4 * std::sin(angle)},
         {0, axis_mm * std::cos(angle), axis_mm * std::sin(angle) + shake}}};
    ImagePose pose{};
    for (std::size_t column = 0; column < 3; ++column) {
      const auto& at = local[column];
      const std::size_t to = column == 2 ? 3 : column;
      pose[to] = std::cos(turn) * at[0] - std::sin(turn) * at[1] + (column == 2 ? 500 : 0);
      pose[4 + to] = std::sin(turn) * at[0] + std::cos(turn) * at[1] - (column == 2 ? 300 : 0);
      pose[8 + to] = at[2];
    }
    pose[15] = 1;
    poses.push_back(pose);
  }
  return poses;
}

TEST(FanFitTest, FindsAPerfectFan) {
  const auto fit = fit_fan(fan(32, 50, 11), 100);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_NEAR(fit->axis_mm, -32, 1e-6);
  EXPECT_NEAR(fit->residual_mm, 0, 1e-6);
  EXPECT_NEAR(fit->turn_deg, 0, 1e-4);
  EXPECT_EQ(why_no_fan(*fit), "");
  for (int i = 0; i < 11; ++i)
    EXPECT_NEAR(degrees(fit->angles_rad[static_cast<std::size_t>(i)]), -25 + 5 * i, 1e-6);
}

TEST(FanFitTest, TellsHowFarPosesAreFromAFan) {
  const auto shaken = fit_fan(fan(32, 50, 12, 2), 100);
  ASSERT_TRUE(shaken);
  EXPECT_NEAR(shaken->residual_mm, 2, 0.1);
  EXPECT_EQ(why_no_fan(*shaken), "");
  EXPECT_NE(why_no_fan(*fit_fan(fan(32, 50, 12, 9), 100)).find("misses the frames by"), std::string::npos);
  EXPECT_NE(why_no_fan(*fit_fan(fan(32, 1, 12), 100)).find("tilt by 1.0 deg only"), std::string::npos);
  std::vector<ImagePose> pushed = fan(32, 50, 12);
  for (std::size_t i = 0; i < pushed.size(); ++i) {  // along the rows
    pushed[i][3] += 3 * static_cast<double>(i) * std::cos(0.7);
    pushed[i][7] += 3 * static_cast<double>(i) * std::sin(0.7);
  }
  EXPECT_NE(why_no_fan(*fit_fan(pushed, 100)).find("slide by"), std::string::npos);
  EXPECT_FALSE(fit_fan(fan(32, 50, 2), 0));
  EXPECT_FALSE(fit_fan(std::vector<ImagePose>(5), 0));
}

/// The liver's sweep has angles that others derived from the same poses, with another sign: by its poses the
/// first frame lies on the side of x cross y. They take the axis to be 28 mm behind the face, with 3.7 mm.
TEST(FanFitTest, FindsTheAnglesOfARealSweep) {
  const auto path = data_folder() / "liver_fan_sweep.igs.mha";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  auto opened = open_recording_file(path, std::uint64_t{1} << 30);
  ASSERT_TRUE(opened) << opened.error().message;
  std::vector<ImagePose> poses;
  for (const SequenceFrame& frame : opened->sequence.frames) poses.push_back(frame.pose.value());
  const auto fit = fit_fan(poses, 369);
  ASSERT_TRUE(fit);
  const double face_mm = 22 * 0.3148178;
  EXPECT_NEAR(face_mm - fit->axis_mm, 28, 8);
  EXPECT_LT(fit->residual_mm, 3.7);
  EXPECT_EQ(why_no_fan(*fit), "");
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_NEAR(degrees(fit->angles_rad[i]), -*opened->sequence.frames[i].motor_angle_deg, 1.5) << i;
}

/// A recording of poses alone plays like one with angles.
TEST(FanFitTest, GivesARecordingItsAngles) {
  const TemporaryFolder folder;
  NamedFile file = fan_recording(7, 1, 20);
  file.remove_all("MotorAngleDeg");
  NamedFile::remove(file.header, "FanlightMotorRadiusMm");
  NamedFile::set(file.header, "FanlightPixelWidthMm", "0.5");
  NamedFile::set(file.header, "FanlightPixelHeightMm", "0.4");
  const std::vector<ImagePose> poses = fan(32, 40, 7);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    std::string text;
    for (const double each : poses[i]) text += fmt::format("{} ", each);
    file.frames[i].emplace_back("ImageToReferenceTransform", text);
  }
  write_file(folder / "x.mha", file.bytes());
  const auto recording = Recording::open({.path = folder / "x.mha", .geometry_path = {}});
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_NEAR(degrees(recording->frames()[0].angle_rad), -20, 1e-6);
  EXPECT_NEAR(recording->summary().smallest_angle_deg, -20, 1e-6);
  EXPECT_NEAR(recording->summary().largest_angle_deg, 20, 1e-6);
  EXPECT_NEAR(recording->summary().geometry.motor_radius_mm, -0.5 * 0.4 + 32, 1e-6);
  ASSERT_EQ(recording->summary().notes.size(), 1U);
  EXPECT_NE(recording->summary().notes[0].find("are fitted to the poses"), std::string::npos);
}

}  // namespace
}  // namespace fanlight::test
