// SPDX-License-Identifier: Apache-2.0
// What was not scanned in volumes on a grid.
#include "acquisition/replay/grid_padding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "acquisition/replay/recording.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

using Look = GridPadding::Look;

constexpr std::array<std::uint32_t, 3> kGridSize = {60, 50, 64};

/// A value for each voxel, by its place in voxels.
std::vector<std::uint8_t> each_voxel(const std::function<int(double, double, double)>& value) {
  std::vector<std::uint8_t> all;
  for (std::uint32_t z = 0; z < kGridSize[2]; ++z) {
    for (std::uint32_t y = 0; y < kGridSize[1]; ++y) {
      for (std::uint32_t x = 0; x < kGridSize[0]; ++x)
        all.push_back(static_cast<std::uint8_t>(value(x, y, z)));
    }
  }
  return all;
}

/// The fan of a curved array that is swept, as it just fills its grid: 31 deg to either side, both ways.
bool in_fan(double x, double y, double z) {
  const double from_axis = std::hypot(y + 16, z - 31.5) - 8;
  const double from_apex = std::hypot(from_axis, x - 29.5);
  return std::abs(std::atan2(z - 31.5, y + 16)) < 0.6 && std::abs(std::atan2(x - 29.5, from_axis)) < 0.6 &&
         from_apex > 12 && from_apex < 59;
}

double share_of(const std::vector<std::uint8_t>& voxels) {
  double sum = 0;
  for (const std::uint8_t voxel : voxels) sum += voxel;
  return sum / static_cast<double>(voxels.size());
}

TEST(GridPaddingTest, IsWhatLiesAroundAFan) {
  const auto outside = each_voxel([](double x, double y, double z) { return in_fan(x, y, z) ? 0 : 1; });
  const GridPadding padding = find_padding(kGridSize, outside);
  EXPECT_EQ(padding.look, Look::kBorder);
  EXPECT_EQ(padding.voxels, outside);
  EXPECT_NEAR(padding.share, share_of(outside), 1e-12);
}

TEST(GridPaddingTest, LeavesOutWhatEchoesEnclose) {
  const auto outside = each_voxel([](double x, double y, double z) { return in_fan(x, y, z) ? 0 : 1; });
  // A cyst.
  const auto enclosed = each_voxel([](double x, double y, double z) {
    return in_fan(x, y, z) && std::hypot(x - 30, y - 30, z - 32) > 4 ? 0 : 1;
  });
  const GridPadding padding = find_padding(kGridSize, enclosed);
  EXPECT_EQ(padding.look, Look::kBorder);
  EXPECT_EQ(padding.voxels, outside);
}

TEST(GridPaddingTest, MayBeFluid) {
  const std::pair<const char*, std::function<bool(double, double, double)>> scenes[] = {
      {"a ball in a bath",
       [](double x, double y, double z) { return std::hypot(x - 30, y - 25, z - 32) < 20; }},
      {"tissue below a bath", [](double x, double y, double) { return y > 30 + 3 * std::sin(x / 5); }},
      {"a dome that nearly fills the grid",
       [](double x, double y, double z) {
         return y > 2 + 0.01 * (std::pow(x - 30, 2) + std::pow(z - 32, 2));
       }},
      {"a wall, a bath and tissue", [](double, double y, double) { return y < 4 || y > 30; }},
      {"a fan of speckle that is clipped to black",
       [](double x, double y, double z) {
         const double noise = std::sin(12.9898 * x + 78.233 * y + 37.719 * z) * 43758.5453;
         return in_fan(x, y, z) && noise - std::floor(noise) > 0.1;
       }},
  };
  for (const auto& [name, has_echo] : scenes) {
    const auto voxels = each_voxel([&](double x, double y, double z) { return has_echo(x, y, z) ? 0 : 1; });
    EXPECT_EQ(find_padding(kGridSize, voxels).look, Look::kFluid) << name;
  }
}

TEST(GridPaddingTest, IsNotInAFullVolume) {
  EXPECT_EQ(find_padding(kGridSize, each_voxel([](double, double, double) { return 0; })).look, Look::kNone);
  EXPECT_EQ(find_padding(kGridSize, each_voxel([](double, double, double) { return 1; })).look, Look::kFluid);
  EXPECT_EQ(find_padding({2, 2, 2}, {0, 0, 0, 0, 0, 0, 0, 0}).look, Look::kNone);
  std::vector<std::uint8_t> thin(std::size_t{40} * 40 * 2);
  for (std::size_t at = 0; at < thin.size(); ++at) thin[at] = at % 40 < 4 ? 1 : 0;
  EXPECT_EQ(find_padding({40, 40, 2}, thin).look, Look::kFluid) << "all voxels are on the border";
}

// ---- in recordings ----

class PaddedVolumeTest : public testing::Test {
 protected:
  /// A volume of 1 mm on a grid, of a type with `bytes`.
  Result<Recording> open(const std::string& type, const std::vector<int>& voxels,
                         const std::string& geometry) {
    std::string text =
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nElementSpacing = 1 1 1\n"
        "DimSize = 60 50 64\nElementType = " +
        type + "\nElementDataFile = LOCAL\n";
    for (const int voxel : voxels) {
      text.push_back(static_cast<char>(voxel));
      if (type == "MET_SHORT") text.push_back(static_cast<char>(voxel >> 8));
    }
    write_file(folder_ / "x.mha", text);
    write_file(folder_ / "x.mha.toml", geometry);
    return Recording::open({.path = folder_ / "x.mha", .geometry_path = {}});
  }

  /// A fan of echoes from `echo` up, `around` outside.
  static std::vector<int> fan(int echo, int around) {
    std::vector<int> voxels;
    for (const std::uint8_t outside :
         each_voxel([](double x, double y, double z) { return in_fan(x, y, z) ? 0 : 1; })) {
      // Fluid above tissue.
      const bool is_fluid = voxels.size() / kGridSize[0] % kGridSize[1] < 20;
      const int more = static_cast<int>(voxels.size() * 7 % (is_fluid ? 10 : 150));
      voxels.push_back(outside != 0 ? around : echo + more);
    }
    return voxels;
  }

  static bool has_note(const Recording& recording, const std::string& part) {
    for (const std::string& note : recording.summary().notes)
      if (note.find(part) != std::string::npos) return true;
    return false;
  }

  /// Pixels are 0 just outside the fan, within a voxel.
  static void expect_fan(const Recording& recording) {
    const FanGeometry& geometry = recording.summary().geometry;
    int inside = 0;
    int outside = 0;
    for (std::size_t frame = 0; frame < recording.frames().size(); ++frame) {
      for (std::uint32_t row = 0; row < geometry.rows; ++row) {
        for (std::uint32_t column = 0; column < geometry.columns; ++column) {
          const Point at = geometry.point(0, {.angle_rad = recording.frames()[frame].angle_rad,
                                              .depth_mm = row * geometry.pixel_height_mm});
          const double y = at.y_mm;
          const double z = at.z_mm + 31.5;
          int corners = 0;
          for (const double down : {-1.0, 0.0, 1.0})
            for (const double across : {-1.0, 0.0, 1.0})
              corners += in_fan(column, y + down, z + across) ? 1 : 0;
          const int pixel = recording.frame_pixels(frame)[std::size_t{row} * geometry.columns + column];
          if (corners == 9 && y < 48 && z > 0 && z < 63) {  // within the grid
            ASSERT_GE(pixel, 1) << frame << ", " << row << ", " << column;
            ++inside;
          }
          if (corners == 0) {
            ASSERT_EQ(pixel, 0) << frame << ", " << row << ", " << column;
            ++outside;
          }
        }
      }
    }
    EXPECT_GT(inside, 10'000);
    EXPECT_GT(outside, 10'000);
  }

  TemporaryFolder folder_;
};

TEST_F(PaddedVolumeTest, HasZerosWhereNothingWasScanned) {
  const struct {
    const char* type;
    int echo;
    int around;
  } kFiles[] = {
      {"MET_UCHAR", 1, 0}, {"MET_UCHAR", 0, 255}, {"MET_SHORT", -900, -1000}, {"MET_SHORT", 0, -32768}};
  for (const auto& [type, echo, around] : kFiles) {
    const auto recording = open(type, fan(echo, around), "");
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_TRUE(recording->summary().geometry.zero_is_unscanned);
    EXPECT_TRUE(has_note(*recording, "was not scanned")) << type << around;
    expect_fan(*recording);
  }
}

TEST_F(PaddedVolumeTest, ChoosesItsWindowByTheEchoesAlone) {
  const auto recording = open("MET_SHORT", fan(0, -32768), "");
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_GE(recording->summary().window.black, 0);
  EXPECT_LE(recording->summary().window.white, 150);
}

TEST_F(PaddedVolumeTest, MayBeDecidedByTheGeometryFile) {
  const auto none = open("MET_UCHAR", fan(1, 0), "unscanned = \"none\"\n");
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_FALSE(none->summary().geometry.zero_is_unscanned);
  EXPECT_FALSE(has_note(*none, "scanned"));

  std::vector<int> ball;
  for (const std::uint8_t voxel : each_voxel(
           [](double x, double y, double z) { return std::hypot(x - 30, y - 25, z - 32) < 20 ? 90 : 0; }))
    ball.push_back(voxel);
  const auto fluid = open("MET_UCHAR", ball, "");
  ASSERT_TRUE(fluid) << fluid.error().message;
  EXPECT_FALSE(fluid->summary().geometry.zero_is_unscanned);
  EXPECT_TRUE(has_note(*fluid, "may be fluid or not scanned"));
  const auto zero = open("MET_UCHAR", ball, "unscanned = \"zero\"\n");
  ASSERT_TRUE(zero) << zero.error().message;
  EXPECT_TRUE(zero->summary().geometry.zero_is_unscanned);

  // One that touches all sides of its grid: tissue alone, with no fluid besides.
  std::vector<int> inscribed;
  for (const std::uint8_t voxel : each_voxel([](double x, double y, double z) {
         const double away = std::hypot((x - 29.5) / 29.5, (y - 24.5) / 24.5, (z - 31.5) / 31.5);
         return away < 1 ? 90 + 20 * std::sin(3 * x + 5 * y + 7 * z) : 0;
       }))
    inscribed.push_back(voxel);
  const auto touching = open("MET_UCHAR", inscribed, "");
  ASSERT_TRUE(touching) << touching.error().message;
  EXPECT_FALSE(touching->summary().geometry.zero_is_unscanned);

  const auto refused = open("MET_UCHAR", ball, "unscanned = \"yes\"\n");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("detect, zero or none"), std::string::npos)
      << refused.error().message;
}

}  // namespace
}  // namespace fanlight::test
