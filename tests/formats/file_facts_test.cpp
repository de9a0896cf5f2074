// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/file_facts.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "acquisition/replay/recording.hpp"
#include "tests/support/data_folder.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;

class GeometryDraftTest : public testing::TestWithParam<const char*> {};

TEST_P(GeometryDraftTest, MakesARealRecordingPlayable) {
  const auto original = data_folder() / GetParam();
  if (!std::filesystem::exists(original)) GTEST_SKIP() << "no real recordings";
  const TemporaryFolder folder;
  const auto path = folder / GetParam();
  std::filesystem::copy(original, path);
  ASSERT_FALSE(Recording::open({.path = path, .geometry_path = {}}));
  const auto facts = look_into(path, kMostBytes);
  ASSERT_TRUE(facts) << facts.error().message;
  const std::string draft = geometry_draft(*facts, "a file");
  const auto written = write_geometry_draft(path, draft);
  ASSERT_TRUE(written) << written.error().message;
  const auto opened = Recording::open({.path = path, .geometry_path = {}});
  EXPECT_TRUE(opened) << opened.error().message << "\n" << draft;
  EXPECT_EQ(write_geometry_draft(path, draft).error().code, ErrorCode::kInvalidArgument)
      << "a geometry that someone may have edited is kept";
}

INSTANTIATE_TEST_SUITE_P(All, GeometryDraftTest,
                         testing::Values("liver_fan_sweep.igs.mha",
                                         "UltrasonixCurvilinearScanConvertedData.igs.mha",
                                         "UltrasonixCurvilinearBrightnessData.igs.mha"));

TEST(FileFactsTest, CountsWhatTheFramesHave) {
  const TemporaryFolder folder;
  NamedFile file = fan_recording(5, 2, 20);
  NamedFile::remove(file.frames[3], "MotorAngleDeg");
  write_file(folder / "x.mha", file.bytes());
  const auto facts = look_into(folder / "x.mha", kMostBytes);
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->frames, 10U);
  EXPECT_EQ(facts->with_time, 10U);
  EXPECT_EQ(facts->with_angle, 9U);
  EXPECT_EQ(facts->columns, 8U);
  EXPECT_EQ(facts->first_frame[0], 1);
  EXPECT_EQ(facts->middle_frame[0], 6);
  EXPECT_FALSE(facts->scan_lines);
}

TEST(FileFactsTest, TellsThatASweepByHandIsNoFan) {
  const auto path = data_folder() / "SpinePhantomFreehand.igs.mha";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no real recordings";
  const auto facts = look_into(path, kMostBytes);
  ASSERT_TRUE(facts);
  EXPECT_NE(facts->no_fan.find("the probe was moved, 33 mm and 2 deg far"), std::string::npos)
      << facts->no_fan;
}

TEST(FileFactsTest, FindsTheAxisByThePosesAlsoWhereFramesHaveAngles) {
  const auto path = data_folder() / "liver_fan_sweep.igs.mha";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no real recordings";
  const auto facts = look_into(path, kMostBytes);
  ASSERT_TRUE(facts && facts->fit);
  EXPECT_EQ(facts->with_angle, 140U);
  EXPECT_NEAR(-facts->fit->axis_mm, 15.3, 0.5);
  EXPECT_NE(geometry_draft(*facts, "liver").find("motor_radius_mm = 22 "), std::string::npos);
}

TEST(FileFactsTest, FailsAsTheReaderDoes) {
  EXPECT_EQ(look_into("/nowhere.mha", kMostBytes).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace fanlight::test
