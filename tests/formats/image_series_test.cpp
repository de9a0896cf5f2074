// SPDX-License-Identifier: Apache-2.0
// Numbered pictures as recordings, with what only their geometry can tell.
#include "acquisition/replay/image_series.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/replay/recording.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr const char* kGeometry =
    "pixel_width_mm = 0.5\npixel_height_mm = 0.5\nface_column = 3.5\nface_row = 0\nmotor_radius_mm = 28\n";

/// A portable grey map, or pixel map with three channels.
std::string picture(int grey, int columns = 8, int rows = 6, const char* kind = "P5") {
  const bool colour = std::string(kind) == "P6";
  std::string bytes = fmt::format("{}\n{} {}\n255\n", kind, columns, rows);
  for (int i = 0; i < columns * rows; ++i) {
    if (colour) bytes += {static_cast<char>(grey), 0, 0};
    if (!colour) bytes.push_back(static_cast<char>(grey));
  }
  return bytes;
}

class ImageSeriesTest : public testing::Test {
 protected:
  ImageSeriesTest() { std::filesystem::create_directory(series_); }

  void write(int first, int frames) {
    for (int i = first; i < first + frames; ++i)
      write_file(series_ / fmt::format("f.{:03}.pgm", i), picture(10 + i));
  }
  void give(const std::string& lines) { write_file(folder_ / "scan.toml", kGeometry + lines); }
  Result<Recording> open(const std::filesystem::path& path) const {
    return Recording::open({.path = path, .geometry_path = {}});
  }
  std::string refusal(const std::filesystem::path& path) const {
    const auto opened = open(path);
    return opened ? "" : opened.error().message;
  }
  static std::vector<double> angles_deg(const Recording& recording) {
    std::vector<double> angles;
    for (const Recording::Frame& frame : recording.frames()) angles.push_back(degrees(frame.angle_rad));
    return angles;
  }

  TemporaryFolder folder_;
  std::filesystem::path series_ = folder_ / "scan";
};

TEST_F(ImageSeriesTest, PlaysAFolderInTheOrderOfTheNumbers) {
  write(95, 10);
  for (int i = 100; i < 105; ++i)  // numbers may have fewer digits
    std::filesystem::rename(series_ / fmt::format("f.{:03}.pgm", i), series_ / fmt::format("f.{}.pgm", i));
  give("frames_per_second = 20\nfirst_angle_deg = -9\nlast_angle_deg = 9\n");
  const auto recording = open(series_);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->frames().size(), 10U);
  EXPECT_EQ(recording->summary().frame_rate_hz, 20);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(recording->frame_pixels(i)[0], 105 + i);
  EXPECT_EQ(recording->summary().columns, 8U);
  EXPECT_TRUE(open(series_ / "")) << "a slash at the end changes nothing";
}

TEST_F(ImageSeriesTest, PlaysAPattern) {
  write(1, 5);
  write_file(series_ / "f.001.pgm.bak", "other files may be there");
  write_file(series_ / "f.%03d.pgm.toml",
             std::string(kGeometry) + "frames_per_second = 20\nangles_deg = [-4, -2, 0.5, 2, 5]\n");
  const auto recording = open(series_ / "f.%03d.pgm");
  ASSERT_TRUE(recording) << recording.error().message;
  const auto angles = angles_deg(*recording);
  EXPECT_NEAR(angles[0], -4, 1e-9);
  EXPECT_NEAR(angles[2], 0.5, 1e-9);
  EXPECT_NE(recording->summary().notes.at(0).find("angles_deg"), std::string::npos);
}

TEST_F(ImageSeriesTest, DividesFramesIntoSweepsToAndFro) {
  write(0, 12);
  give(
      "frames_per_second = 20\nframes_per_sweep = 4\nsweep_order = \"to-and-fro\"\nangles_deg = [-6, -1, 3, "
      "6]\n");
  const auto recording = open(series_);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->sweeps().size(), 3U);
  EXPECT_EQ(recording->sweeps()[1].direction, SweepDirection::kBackward);
  const auto angles = angles_deg(*recording);
  const double expected[] = {-6, -1, 3, 6, 6, 3, -1, -6, -6, -1, 3, 6};
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(angles[i], expected[i], 1e-9) << i;
}

TEST_F(ImageSeriesTest, ASweepMayBeginElsewhereEachTime) {
  write(0, 8);
  give(
      "frames_per_second = 20\nframes_per_sweep = 4\nfirst_angle_deg = -6\nlast_angle_deg = 6\n"
      "sweep_starts_deg = [-10, -3]\n");
  const auto recording = open(series_);
  ASSERT_TRUE(recording) << recording.error().message;
  const auto angles = angles_deg(*recording);
  const double expected[] = {-10, -6, -2, 2, -3, 1, 5, 9};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(angles[i], expected[i], 1e-9) << i;
}

TEST_F(ImageSeriesTest, IsRefusedInOneSentence) {
  EXPECT_NE(refusal(series_).find("no such pictures"), std::string::npos) << refusal(series_);
  write(0, 5);
  give("first_angle_deg = -9\nlast_angle_deg = 9\n");
  EXPECT_NE(refusal(series_).find("frames_per_second in the geometry"), std::string::npos)
      << refusal(series_);
  const std::string rate = "frames_per_second = 20\n";
  const std::pair<const char*, const char*> wrong[] = {
      {"angles_deg = [1, 2]\n", "angles_deg has 2 numbers"},
      {"angles_deg = []\n", "no list of numbers"},
      {"angles_deg = [1, \"a\"]\n", "no list of numbers"},
      {"angles_deg = 4\n", "no list of numbers"},
      {"sweep_starts_deg = [1, 2]\n", "sweep_starts_deg has 2 numbers"},
      {"sweep_starts_deg = [1]\n", "no angles within a sweep"},
      {"frames_per_sweep = 1.5\nfirst_angle_deg = 0\nlast_angle_deg = 9\n", "frames_per_sweep is 1.5"},
  };
  for (const auto& [lines, expected] : wrong) {
    give(rate + lines);
    EXPECT_NE(refusal(series_).find(expected), std::string::npos) << lines << refusal(series_);
  }
  give("frames_per_second = 0\n");
  EXPECT_NE(refusal(series_).find("frames_per_second is 0"), std::string::npos);
  give(rate + "first_angle_deg = -9\nlast_angle_deg = 9\n");
  write_file(series_ / "f.003.pgm", picture(5, 9, 6));
  EXPECT_NE(refusal(series_).find("9 x 6 pixels, expected 8 x 6"), std::string::npos) << refusal(series_);
  write_file(series_ / "f.003.pgm", "P5\n8 6\n255\n");
  EXPECT_FALSE(refusal(series_).empty()) << "a picture that is cut off";
  std::filesystem::remove(series_ / "f.003.pgm");
  EXPECT_NE(refusal(series_).find("picture 2 is followed by 4"), std::string::npos) << refusal(series_);
  write_file(series_ / "x.png", "no picture");
  EXPECT_NE(refusal(series_).find("several endings"), std::string::npos) << refusal(series_);
}

TEST_F(ImageSeriesTest, ReadsColourAsLuminanceAndSixteenBits) {
  for (int i = 0; i < 3; ++i) write_file(series_ / fmt::format("c{}.ppm", i), picture(200, 8, 6, "P6"));
  for (int i = 0; i < 3; ++i) {
    std::string wide = "P5\n8 6\n65535\n";
    for (int k = 0; k < 48; ++k) wide += {static_cast<char>(i), static_cast<char>(k)};
    write_file(folder_ / fmt::format("w{}.pgm", i), wide);
  }
  auto wide = ImageSeries::open(folder_ / "w%d.pgm");
  ASSERT_TRUE(wide) << wide.error().message;
  EXPECT_EQ((*wide)->format().bytes, 2U);
  std::vector<std::uint8_t> values(96);
  ASSERT_TRUE((*wide)->read(2, values));
  EXPECT_EQ(reinterpret_cast<const std::uint16_t*>(values.data())[5], 2 * 256 + 5);
  auto colour = ImageSeries::open(series_ / "c%d.ppm");
  ASSERT_TRUE(colour) << colour.error().message;
  values.resize(48);
  ASSERT_TRUE((*colour)->read(0, values));
  EXPECT_EQ(values[0], 60) << "0.299 of red";
}

}  // namespace
}  // namespace fanlight::test
