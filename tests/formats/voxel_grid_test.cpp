// SPDX-License-Identifier: Apache-2.0
// Volumes on a grid as recordings.
#include "acquisition/replay/voxel_grid.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "acquisition/replay/recording.hpp"
#include "tests/support/nrrd_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr std::uint32_t kColumns = 12;
constexpr std::uint32_t kRows = 20;
constexpr std::uint32_t kSlices = 30;

/// Grey level of a voxel; not the same along any axis, nor under an exchange of two.
constexpr int grey(std::uint32_t i, std::uint32_t j, std::uint32_t k) {
  return static_cast<int>(20 + 2 * i + 5 * j + 3 * k);
}

std::string voxels(int bytes, bool big_endian, int volumes = 1) {
  std::string all;
  for (int volume = 0; volume < volumes; ++volume) {
    for (std::uint32_t k = 0; k < kSlices; ++k) {
      for (std::uint32_t j = 0; j < kRows; ++j) {
        for (std::uint32_t i = 0; i < kColumns; ++i) {
          const int value = grey(i, j, k) + volume;
          if (bytes == 1) {
            all.push_back(static_cast<char>(value));
          } else {
            const char high = static_cast<char>(value >> 8);
            const char low = static_cast<char>(value);
            if (big_endian) all += {high, low};
            if (!big_endian) all += {low, high};
          }
        }
      }
    }
  }
  return all;
}

class VoxelGridTest : public testing::Test {
 protected:
  Result<Recording> open(const std::string& name, const std::string& bytes) {
    write_file(folder_ / name, bytes);
    return Recording::open({.path = folder_ / name, .geometry_path = {}});
  }

  /// Each pixel within the grid has the value that the grid has there.
  static void expect_grid(const Recording& recording, bool turned = false, int more = 0,
                          std::uint32_t sweep = 0) {
    const FanGeometry& geometry = recording.summary().geometry;
    const Recording::Sweep& of = recording.sweeps()[sweep];
    int compared = 0;
    for (std::uint32_t frame = of.first_frame; frame < of.first_frame + of.frames; ++frame) {
      for (std::uint32_t row = 0; row < geometry.rows; ++row) {
        const Point at = geometry.point(0, {.angle_rad = recording.frames()[frame].angle_rad,
                                            .depth_mm = row * geometry.pixel_height_mm});
        const double j = at.y_mm / 1.5;
        const double k = at.z_mm / 2 + (kSlices - 1) / 2.0;
        if (j < 0 || j > kRows - 1 || k < 0 || k > kSlices - 1) continue;
        for (const std::uint32_t i : {0U, 5U, kColumns - 1}) {
          const std::uint32_t column = turned ? kColumns - 1 - i : i;
          ASSERT_NEAR(recording.frame_pixels(frame)[row * kColumns + column],
                      20 + 2.0 * i + 5 * j + 3 * k + more, 0.6)
              << frame << ", " << row;
          ++compared;
        }
      }
    }
    EXPECT_GT(compared, 1000);
  }

  static std::string nrrd(const std::string& fields) {
    return fmt::format("NRRD0005\ntype: uint8\ndimension: 3\nsizes: {} {} {}\nencoding: raw\n{}\n", kColumns,
                       kRows, kSlices, fields);
  }
  static std::string mha(const std::string& fields, const std::string& size = "12 20 30") {
    return fmt::format(
        "ObjectType = Image\nNDims = {}\nBinaryData = True\n{}ElementSpacing = 0.5 1.5 2{}\n"
        "DimSize = {}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        size.size() > 8 ? 4 : 3, fields, size.size() > 8 ? " 1" : "", size);
  }

  TemporaryFolder folder_;
};

TEST_F(VoxelGridTest, HasItsVoxelsWhereTheyWere) {
  const auto recording = open("x.mha", mha("") + voxels(1, false));
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_EQ(recording->summary().geometry.pixel_width_mm, 0.5);
  expect_grid(*recording);
  EXPECT_NE(recording->summary().notes.at(0).find("12 x 20 x 30 voxels of 0.5 x 1.5 x 2 mm"),
            std::string::npos)
      << recording->summary().notes.at(0);
}

TEST_F(VoxelGridTest, MayBeANrrd) {
  for (const char* const fields :
       {"spacings: 0.5 1.5 2\n",
        "kinds: domain domain domain\nspace directions: (0.5,0,0) (0,1.5,0) (0,0,2)\n",
        "kinds: space space space\nspace: right-anterior-superior\nspace directions: (0,0.5,0) (0,0,1.5) "
        "(2,0,0)\n"}) {
    const auto recording = open("x.nrrd", nrrd(fields) + voxels(1, false));
    ASSERT_TRUE(recording) << recording.error().message;
    expect_grid(*recording);
  }
}

TEST_F(VoxelGridTest, TurnsLeftHandedAxesRound) {
  const auto nrrd_file = open(
      "x.nrrd", nrrd("space: left-posterior-superior\nspace directions: (-0.5,0,0) (0,1.5,0) (0,0,2)\n") +
                    voxels(1, false));
  ASSERT_TRUE(nrrd_file) << nrrd_file.error().message;
  expect_grid(*nrrd_file, true);
  const auto meta_image = open("x.mha", mha("TransformMatrix = 1 0 0 0 1 0 0 0 -1\n") + voxels(1, false));
  ASSERT_TRUE(meta_image) << meta_image.error().message;
  expect_grid(*meta_image, true);
}

/// What `fanlight convert` writes comes back where it was.
TEST_F(VoxelGridTest, OfOurOwnLiesWhereItLay) {
  const auto recording =
      open("x.nrrd", nrrd("space: left-posterior-superior\nspace origin: (3,-10.5,7)\n"
                          "space directions: (0.5,0,0) (0,1.5,0) (0,0,2)\nFanlightAxes:=transducer\n") +
                         voxels(1, false));
  ASSERT_TRUE(recording) << recording.error().message;
  const FanGeometry& geometry = recording->summary().geometry;
  EXPECT_NEAR(geometry.plane_point({0, 0}).x_mm, 3, 1e-9);
  int compared = 0;
  for (std::size_t frame = 0; frame < recording->frames().size(); ++frame) {
    for (std::uint32_t row = 0; row < geometry.rows; ++row) {
      const Point at = geometry.point(0, {.angle_rad = recording->frames()[frame].angle_rad,
                                          .depth_mm = geometry.plane_point({0, 1.0 * row}).depth_mm});
      const double j = (at.y_mm + 10.5) / 1.5;
      const double k = (at.z_mm - 7) / 2;
      if (j < 0 || j > kRows - 1 || k < 0 || k > kSlices - 1) continue;
      ASSERT_NEAR(recording->frame_pixels(frame)[row * kColumns], 20 + 5 * j + 3 * k, 0.6);
      ++compared;
    }
  }
  EXPECT_GT(compared, 300);
  for (const std::string& note : recording->summary().notes)
    EXPECT_EQ(note.find("radians"), std::string::npos);
}

TEST_F(VoxelGridTest, HasItsListOnEitherSide) {
  const auto recording =
      open("x.nrrd",
           "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 1 12 20 30\nencoding: raw\nspacings: nan 0.5 1.5 2\n"
           "kinds: list domain domain domain\n\n" +
               voxels(1, false));
  ASSERT_TRUE(recording) << recording.error().message;
  expect_grid(*recording);
}

TEST_F(VoxelGridTest, TakesOnlyTheWindowFromAGeometryFile) {
  write_file(folder_ / "x.mha.toml", "motor_radius_mm = 30\n");
  const auto refused = open("x.mha", mha("") + voxels(1, false));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("motor_radius_mm for a volume on a grid"), std::string::npos)
      << refused.error().message;
  write_file(folder_ / "x.mha.toml", "angles_deg = [1, 2]\n");
  EXPECT_FALSE(open("x.mha", mha("") + voxels(1, false)));
}

TEST_F(VoxelGridTest, MayHaveSixteenBitsInBothByteOrders) {
  for (const bool big : {false, true}) {
    const std::string header = fmt::format(
        "NRRD0005\ntype: {}\ndimension: 3\nsizes: 12 20 30\nspacings: 0.5 1.5 2\nencoding: gzip\nendian: "
        "{}\n\n",
        big ? "int16" : "uint16", big ? "big" : "little");
    write_file(folder_ / "x.nrrd.toml", "window_black = 0\nwindow_white = 255\n");
    const auto recording = open("x.nrrd", header + gzipped(voxels(2, big)));
    ASSERT_TRUE(recording) << recording.error().message;
    expect_grid(*recording);
  }
}

TEST_F(VoxelGridTest, MayBeSeveralVolumes) {
  const auto meta_image = open("x.mha", mha("", "12 20 30 3") + voxels(1, false, 3));
  ASSERT_TRUE(meta_image) << meta_image.error().message;
  const auto nrrd_file =
      open("x.nrrd",
           "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 12 20 30 3\nencoding: raw\nspacings: 0.5 "
           "1.5 2 nan\nkinds: domain domain domain list\n\n" +
               voxels(1, false, 3));
  ASSERT_TRUE(nrrd_file) << nrrd_file.error().message;
  for (const Recording* const recording : {&*meta_image, &*nrrd_file}) {
    ASSERT_EQ(recording->summary().sweeps, 3U);
    for (std::uint32_t volume = 0; volume < 3; ++volume)
      expect_grid(*recording, false, static_cast<int>(volume), volume);
  }
}

TEST_F(VoxelGridTest, IsRefusedInOneSentence) {
  const auto refusal = [&](const std::string& name, const std::string& header) {
    const auto opened = open(name, header + voxels(1, false));
    return opened ? "" : opened.error().message;
  };
  const auto has = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_NE(text.find("expected"), std::string::npos) << text;
  };
  has(refusal("x.mha", mha("TransformMatrix = 1 0 0 0.5 1 0 0 0 1\n")), "oblique");
  has(refusal("x.mha", mha("TransformMatrix = 1 0\n")), "oblique");
  has(refusal("x.mha", mha("", "12 20 60")), "expected 14400");  // there are half of them
  has(refusal("x.mha", mha("", "12 300 1")), "a side of the volume has 1 voxels");
  has(refusal("x.nrrd", nrrd("spacings: 0.5 1.5 200\n")), "30 voxels of 200 mm");
  has(refusal("x.nrrd", nrrd("spacings: 0.5 x 2\n")), "oblique, or have no length");
  has(refusal("x.mha", mha("DistanceUnits = cm\n")), "expected mm");
  has(refusal("x.nrrd", nrrd("spacings: 0.5 1.5 2\nunits: \"cm\" \"cm\" \"cm\"\n")), "lengths in");
  has(refusal("x.nrrd", nrrd("")), "describe frames");
  has(refusal("x.nrrd", nrrd("space directions: (1,0,0) none (0,0,1)\n")), "expected");
}

/// A flat and wide grid of a few kilobytes would be a fan of many gigabytes.
TEST_F(VoxelGridTest, MayNotGrowMuch) {
  const VoxelGrid flat{.size = {4096, 2, 4096}, .spacing_mm = {0.1, 0.03, 0.12}};
  const auto refused = check(flat, "x");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("planes of"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(check({.size = {2, 2, 2}, .spacing_mm = {1, 1, 1}, .volumes = 600'000}, "x"));
  EXPECT_FALSE(check({.size = {2, 2, 2}, .spacing_mm = {1, 1, 1}, .origin_mm = {{0, 1e9, 0}}}, "x"));
  EXPECT_TRUE(check({.size = {256, 256, 256}, .spacing_mm = {0.5, 0.5, 0.5}, .volumes = 20}, "x"));
}

TEST(AxisVectorsTest, TellHandednessAndLengths) {
  const auto right = orthogonal({{{0, 2, 0}, {0, 0, 3}, {4, 0, 0}}});
  ASSERT_TRUE(right);
  EXPECT_FALSE(right->is_left_handed);
  EXPECT_EQ(right->lengths[1], 3);
  EXPECT_TRUE(orthogonal({{{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}})->is_left_handed);
  EXPECT_FALSE(orthogonal({{{1, 0, 0}, {0, 0, 0}, {0, 0, 1}}}));
  EXPECT_FALSE(orthogonal({{{1, 0, 0}, {0.1, 1, 0}, {0, 0, 1}}}));
}

}  // namespace
}  // namespace fanlight::test
