// SPDX-License-Identifier: Apache-2.0
// What Fanlight writes in other formats. `vtk_reads` beside this file asks an independent reader.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "acquisition/convert/converted_files.hpp"
#include "proto/model/fan_geometry.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

const Progress kGoOn = [](double share) { return share <= 1; };

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

FanGeometry convex() {
  return {.kind = FrameKind::kConvexLines,
          .columns = 65,
          .rows = 80,
          .pixel_height_mm = 1,
          .face_column = 32,
          .face_row = 0,
          .motor_radius_mm = 25,
          .probe_radius_mm = 40,
          .line_pitch_deg = 1};
}

/// A volume whose grey levels rise evenly with the line, the sample and the angle.
Volume ramps(const FanGeometry& geometry, std::uint32_t frames) {
  Volume volume(geometry, frames);
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    const auto pixels = volume.next_frame_pixels();
    for (std::uint32_t row = 0; row < geometry.rows; ++row) {
      for (std::uint32_t column = 0; column < geometry.columns; ++column)
        pixels[row * geometry.columns + column] = static_cast<std::uint8_t>(10 + row + column + 2 * frame);
    }
    volume.add_frame({.sequence = frame, .angle_rad = radians(-15.0 + 30.0 * frame / (frames - 1))});
  }
  volume.sort_by_angle();
  return volume;
}

TEST(ScanConversion, PutsEachVoxelWhereTheFanHasIt) {
  const FanGeometry geometry = convex();
  const Volume volume = ramps(geometry, 31);
  const auto grid = scan_converted(volume, 2, kGoOn);
  ASSERT_TRUE(grid) << grid.error().message;
  int compared = 0;
  int outside = 0;
  const std::uint8_t* voxel = grid->voxels.data();
  for (std::uint32_t k = 0; k < grid->size[2]; ++k) {
    for (std::uint32_t j = 0; j < grid->size[1]; ++j) {
      for (std::uint32_t i = 0; i < grid->size[0]; ++i, ++voxel) {
        const auto at = geometry.fan_coordinate(grid->origin_mm[1] + 2.0 * j, grid->origin_mm[2] + 2.0 * k);
        const FramePlace place =
            geometry.frame_place({.x_mm = grid->origin_mm[0] + 2.0 * i, .depth_mm = at.depth_mm});
        const double frame = degrees(at.angle_rad) + 15;
        const bool inside = frame >= 0 && frame <= 30 && place.column >= 0 && place.column <= 64 &&
                            place.row >= 0 && place.row <= 79;
        if (inside) {
          ASSERT_NEAR(*voxel, 10 + place.row + place.column + 2 * frame, 1) << i << ", " << j << ", " << k;
          ++compared;
        } else {
          ASSERT_EQ(*voxel, 0);
          ++outside;
        }
      }
    }
  }
  EXPECT_GT(compared, 10'000);
  EXPECT_GT(outside, 10'000);
}

TEST(ScanConversion, LeavesOutWhatASectorDidNotScan) {
  FanGeometry geometry = {.columns = 60,
                          .rows = 60,
                          .pixel_width_mm = 1,
                          .pixel_height_mm = 1,
                          .face_column = 29.5,
                          .motor_radius_mm = 20,
                          .probe_radius_mm = 30};
  const auto all = scan_converted(ramps(geometry, 5), 1, kGoOn);
  geometry.sector = {.half_angle_deg = 20, .reach_mm = 80};
  const auto sector = scan_converted(ramps(geometry, 5), 1, kGoOn);
  ASSERT_TRUE(all && sector);
  const auto bright = [](const GridVolume& grid) {
    return std::ranges::count_if(grid.voxels, [](std::uint8_t grey) { return grey > 0; });
  };
  EXPECT_LT(bright(*sector), 0.9 * static_cast<double>(bright(*all)));
  EXPECT_GT(bright(*sector), 0.3 * static_cast<double>(bright(*all)));
}

TEST(ScanConversion, RefusesSpacingsThatNoMachineHolds) {
  const Volume volume = ramps(convex(), 5);
  for (const double spacing_mm : {0.0, -1.0, 0.001, 0.02, 1000.0, std::nan("")})
    EXPECT_EQ(scan_converted(volume, spacing_mm, kGoOn).error().code, ErrorCode::kInvalidArgument)
        << spacing_mm;
  EXPECT_EQ(scan_converted(volume, 2, [](double) { return false; }).error().code, ErrorCode::kStopped);
  const double usual_mm = usual_spacing_mm(volume);
  EXPECT_GT(usual_mm, 0.1);
  EXPECT_LT(usual_mm, 1);
}

class ConvertedFiles : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::filesystem::path recording_ = folder_ / "r.igs.mha";
};

TEST_F(ConvertedFiles, AreWholeOrNotThereAndReplaceNothing) {
  const auto grid = scan_converted(ramps(convex(), 5), 4, kGoOn);
  ASSERT_TRUE(grid);
  const auto path = folder_ / "x.nrrd";
  ASSERT_TRUE(write_grid_nrrd(path, *grid));
  const std::string first = content_of(path);
  EXPECT_EQ(write_grid_nrrd(path, *grid).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(content_of(path), first);
  EXPECT_EQ(std::filesystem::status(path).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  EXPECT_EQ(write_grid_nrrd(folder_ / "nowhere" / "x.nrrd", *grid).error().code, ErrorCode::kUnavailable);
  write_file(recording_, fan_recording(5, 2, 20).bytes());
  EXPECT_EQ(write_sequence_nrrd(folder_ / "y.seq.nrrd", {.path = recording_, .geometry_path = {}},
                                [](double) { return false; })
                .error()
                .code,
            ErrorCode::kStopped);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "y.seq.nrrd"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 2)
      << "nothing is left over";
}

TEST_F(ConvertedFiles, NiftiSaysWhereItsVoxelsAre) {
  GridVolume grid{.origin_mm = {-3, 5, -7}, .spacing_mm = 0.5, .size = {2, 3, 4}, .voxels = {}};
  grid.voxels.resize(24, 9);
  ASSERT_TRUE(write_grid_nifti(folder_ / "x.nii", grid));
  const std::string bytes = content_of(folder_ / "x.nii");
  ASSERT_EQ(bytes.size(), 352 + 24U);
  const auto number = [&bytes]<typename T>(std::size_t offset, T) {
    T value{};
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
  };
  EXPECT_EQ(number(0, std::int32_t{}), 348);
  EXPECT_EQ(number(42, std::int16_t{}), 2);
  EXPECT_EQ(number(46, std::int16_t{}), 4);
  EXPECT_EQ(number(280, float{}), -0.5F) << "x grows to the left";
  EXPECT_EQ(number(292, float{}), 3);
  EXPECT_EQ(number(300, float{}), -0.5F);
  EXPECT_EQ(number(308, float{}), -5);
  EXPECT_EQ(number(320, float{}), 0.5F);
  EXPECT_EQ(number(324, float{}), -7);
  ASSERT_TRUE(write_grid_nifti(folder_ / "x.nii.gz", grid));
  std::string unpacked(bytes.size(), '\0');
  const gzFile file = gzopen((folder_ / "x.nii.gz").c_str(), "rb");
  EXPECT_EQ(gzread(file, unpacked.data(), 1000), static_cast<int>(bytes.size()));
  gzclose(file);
  EXPECT_EQ(unpacked, bytes);
}

TEST_F(ConvertedFiles, ASequenceComesBackAsItWas) {
  NamedFile file = fan_recording(5, 2, 20);
  NamedFile::set(file.frames[3], "ImageStatus", "INVALID");
  write_file(recording_, file.bytes());
  const auto first = folder_ / "first.seq.nrrd";
  const auto second = folder_ / "second.seq.nrrd";
  ASSERT_TRUE(write_sequence_nrrd(first, {.path = recording_, .geometry_path = {}}, kGoOn));
  const auto written = write_sequence_nrrd(second, {.path = first, .geometry_path = {}}, kGoOn);
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(content_of(first), content_of(second)) << "read and written again";
  const auto original = Recording::open({.path = recording_, .geometry_path = {}}).value();
  const auto converted = Recording::open({.path = first, .geometry_path = {}}).value();
  ASSERT_EQ(converted.frames().size(), original.frames().size());
  EXPECT_EQ(converted.sweeps().size(), original.sweeps().size());
  EXPECT_EQ(converted.summary().geometry, original.summary().geometry);
  for (std::size_t i = 0; i < original.frames().size(); ++i) {
    EXPECT_EQ(converted.frames()[i].angle_rad, original.frames()[i].angle_rad);
    EXPECT_NEAR(static_cast<double>(converted.frames()[i].time_ns),
                static_cast<double>(original.frames()[i].time_ns), 2);
    EXPECT_TRUE(i == 3 || std::ranges::equal(converted.frame_pixels(i), original.frame_pixels(i))) << i;
  }
}

}  // namespace
}  // namespace fanlight::test
