// SPDX-License-Identifier: Apache-2.0
#include "server/codec/surface_mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr std::uint32_t kPixels = 60;
constexpr double kRadiusMm = 20;

/// A sphere of 20 mm about (0, 50, 0), seen along y, in front of a plane 100 mm away.
Picture sphere_before_plane(bool with_plane) {
  Picture picture = blank_picture(kPixels, kPixels);
  picture.stamp.view = {.origin_mm = {0, 0, 0},
                        .right = {1, 0, 0},
                        .down = {0, 0, -1},
                        .forward = {0, 1, 0},
                        .mm_per_pixel = 1,
                        .middle_column = 29.5,
                        .middle_row = 29.5};
  for (std::uint32_t row = 0; row < kPixels; ++row) {
    for (std::uint32_t column = 0; column < kPixels; ++column) {
      const double from_middle_mm = std::hypot(column - 29.5, row - 29.5);
      const bool sphere = from_middle_mm < 17;
      const std::size_t pixel = row * kPixels + column;
      picture.depth_mm[pixel] =
          sphere ? static_cast<float>(50 - std::sqrt(kRadiusMm * kRadiusMm - from_middle_mm * from_middle_mm))
                 : (with_plane ? 100.0F : -1.0F);
      picture.rgba[4 * pixel] = sphere ? 200 : 50;
    }
  }
  return picture;
}

TEST(SurfaceMesh, LiesWhereTheSurfaceIs) {
  const SurfaceMesh mesh = mesh_of(sphere_before_plane(false));
  ASSERT_GT(mesh.triangles.size(), 1500U);
  ASSERT_EQ(mesh.normals.size(), mesh.points_mm.size());
  ASSERT_EQ(mesh.colours.size(), mesh.points_mm.size());
  for (std::size_t i = 0; i < mesh.points_mm.size(); ++i) {
    const auto& [x, y, z] = mesh.points_mm[i];
    EXPECT_NEAR(std::hypot(x, y - 50, z), kRadiusMm, 1e-3);
    // Outward, towards the camera at y = 0.
    const auto& [nx, ny, nz] = mesh.normals[i];
    EXPECT_GT((nx * x + ny * (y - 50) + nz * z) / kRadiusMm, 0.9) << i;
    EXPECT_EQ(mesh.colours[i][0], 200);
  }
}

TEST(SurfaceMesh, DoesNotBridgeAStepInDepth) {
  const SurfaceMesh mesh = mesh_of(sphere_before_plane(true));
  for (const auto& triangle : mesh.triangles) {
    std::set<int> colours;
    for (const std::uint32_t corner : triangle) colours.insert(mesh.colours[corner][0]);
    EXPECT_EQ(colours.size(), 1U) << "a triangle from the sphere to the plane behind it";
  }
}

TEST(SurfaceMesh, IsWrittenInBothForms) {
  const TemporaryFolder folder;
  const SurfaceMesh mesh = mesh_of(sphere_before_plane(false));
  const auto bytes_of = [](const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  ASSERT_TRUE(write_mesh(folder / "x.stl", mesh));
  EXPECT_EQ(bytes_of(folder / "x.stl").size(), 84 + 50 * mesh.triangles.size());
  ASSERT_TRUE(write_mesh(folder / "x.ply", mesh));
  const std::string ply = bytes_of(folder / "x.ply");
  const std::size_t header = ply.find("end_header\n") + 11;
  EXPECT_EQ(ply.size() - header, 27 * mesh.points_mm.size() + 13 * mesh.triangles.size());
  EXPECT_FALSE(write_mesh(folder / "x.obj", mesh));
  EXPECT_EQ(write_mesh(folder / "y.ply", {}).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(std::filesystem::exists(folder / "y.ply"));
}

}  // namespace
}  // namespace fanlight::test
