// SPDX-License-Identifier: Apache-2.0
#include "server/codec/surface_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "proto/base/file_replacement.hpp"

namespace fanlight {

namespace {

static_assert(std::endian::native == std::endian::little,
              "both formats are written as the machine stores numbers");

using Vector = std::array<double, 3>;

Vector minus(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
std::array<float, 3> unit(const Vector& vector) {
  const double length = std::sqrt(dot(vector, vector));
  const double scale = length > 0 ? 1 / length : 0;
  return {static_cast<float>(vector[0] * scale), static_cast<float>(vector[1] * scale),
          static_cast<float>(vector[2] * scale)};
}
Vector as_vector(const std::array<float, 3>& values) {
  return {values[0], values[1], values[2]};
}

/// Builds the mesh of one picture.
class Mesher {
 public:
  explicit Mesher(const Picture& picture)
      : picture_(picture), view_(picture.stamp.view), index_(picture.depth_mm.size(), kNone) {}

  SurfaceMesh mesh() {
    for (std::uint32_t row = 0; row + 1 < picture_.height; ++row) {
      for (std::uint32_t column = 0; column + 1 < picture_.width; ++column) add_square(column, row);
    }
    for (const Vector& sum : normal_sums_) mesh_.normals.push_back(unit(sum));
    return std::move(mesh_);
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::size_t pixel(std::uint32_t column, std::uint32_t row) const {
    return std::size_t{row} * picture_.width + column;
  }

  double pixel_mm(double depth_mm) const { return view_.mm_per_pixel + depth_mm * view_.mm_per_pixel_per_mm; }

  bool together(std::size_t a, std::size_t b) const {
    const double one_mm = picture_.depth_mm[a];
    const double other_mm = picture_.depth_mm[b];
    constexpr double kMostSlope = 2.5;
    return one_mm >= 0 && other_mm >= 0 &&
           std::abs(one_mm - other_mm) <= kMostSlope * pixel_mm(std::min(one_mm, other_mm));
  }

  /// The square's diagonal joins the corners that are nearer to each other in depth.
  void add_square(std::uint32_t column, std::uint32_t row) {
    const std::size_t upper_left = pixel(column, row);
    const std::size_t upper_right = upper_left + 1;
    const std::size_t lower_left = upper_left + picture_.width;
    const std::size_t lower_right = lower_left + 1;
    const auto step = [&](std::size_t a, std::size_t b) {
      const bool both = picture_.depth_mm[a] >= 0 && picture_.depth_mm[b] >= 0;
      return both ? std::abs(picture_.depth_mm[a] - picture_.depth_mm[b]) : std::numeric_limits<float>::max();
    };
    if (step(upper_left, lower_right) <= step(upper_right, lower_left)) {
      add_triangle(upper_left, lower_left, lower_right);
      add_triangle(upper_left, lower_right, upper_right);
    } else {
      add_triangle(upper_left, lower_left, upper_right);
      add_triangle(upper_right, lower_left, lower_right);
    }
  }

  void add_triangle(std::size_t a, std::size_t b, std::size_t c) {
    if (!together(a, b) || !together(b, c) || !together(a, c)) return;
    const std::array<std::uint32_t, 3> corners = {point(a), point(b), point(c)};
    const Vector at = as_vector(mesh_.points_mm[corners[0]]);
    // Its length is twice the area: large triangles count more for the normals of their points.
    const Vector normal = cross(minus(as_vector(mesh_.points_mm[corners[1]]), at),
                                minus(as_vector(mesh_.points_mm[corners[2]]), at));
    for (const std::uint32_t corner : corners) {
      for (std::size_t axis = 0; axis < 3; ++axis) normal_sums_[corner][axis] += normal[axis];
    }
    mesh_.triangles.push_back(corners);
  }

  std::uint32_t point(std::size_t pixel) {
    if (index_[pixel] != kNone) return index_[pixel];
    index_[pixel] = static_cast<std::uint32_t>(mesh_.points_mm.size());
    const double depth_mm = picture_.depth_mm[pixel];
    const double right =
        (static_cast<double>(pixel % picture_.width) - view_.middle_column) * pixel_mm(depth_mm);
    const std::size_t row = pixel / picture_.width;
    const double down = (static_cast<double>(row) - view_.middle_row) * pixel_mm(depth_mm);
    std::array<float, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = static_cast<float>(view_.origin_mm[axis] + depth_mm * view_.forward[axis] +
                                    right * view_.right[axis] + down * view_.down[axis]);
    }
    mesh_.points_mm.push_back(at);
    // The picture of glass has the colours of what lies behind.
    constexpr std::array<std::uint8_t, 3> kPlain{200, 200, 200};
    const std::uint8_t* const rgba = &picture_.rgba[4 * pixel];
    mesh_.colours.push_back(view_.part.seen_through ? kPlain : std::array{rgba[0], rgba[1], rgba[2]});
    normal_sums_.emplace_back();
    return index_[pixel];
  }

  const Picture& picture_;
  const PictureView& view_;
  std::vector<std::uint32_t> index_;  // of the point of each pixel
  std::vector<Vector> normal_sums_;
  SurfaceMesh mesh_;
};

void append(std::string& bytes, const void* values, std::size_t size) {
  bytes.append(static_cast<const char*>(values), size);
}

std::string ply(const SurfaceMesh& mesh) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment Fanlight; mm in the transducer frame\nelement vertex "
      "{}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.points_mm.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.points_mm.size(); ++i) {
    append(bytes, &mesh.points_mm[i], 12);
    append(bytes, &mesh.normals[i], 12);
    append(bytes, &mesh.colours[i], 3);
  }
  for (const auto& triangle : mesh.triangles) {
    bytes.push_back(3);
    append(bytes, &triangle, 12);
  }
  return bytes;
}

std::string stl(const SurfaceMesh& mesh) {
  std::string bytes = "Fanlight; mm in the transducer frame";
  bytes.resize(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  append(bytes, &count, 4);
  for (const auto& triangle : mesh.triangles) {
    const Vector at = as_vector(mesh.points_mm[triangle[0]]);
    const auto normal = unit(cross(minus(as_vector(mesh.points_mm[triangle[1]]), at),
                                   minus(as_vector(mesh.points_mm[triangle[2]]), at)));
    append(bytes, &normal, 12);
    for (const std::uint32_t corner : triangle) append(bytes, &mesh.points_mm[corner], 12);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace

SurfaceMesh mesh_of(const Picture& picture) {
  return Mesher(picture).mesh();
}

Result<void> check_mesh_path(const std::string& path) {
  if (path.empty() || path.ends_with(".ply") || path.ends_with(".stl")) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("{} is not a file name for a surface, expected one that ends in .ply or .stl", path)};
}

Result<void> write_mesh(const std::string& path, const SurfaceMesh& mesh, FileAccess access) {
  if (auto named = check_mesh_path(path); !named) return named;
  if (mesh.triangles.empty())
    return Error{ErrorCode::kNotFound, "the picture shows no surface, expected one to write"};
  access.mode = 0600;  // a face is a patient's
  return replace_file(path, path.ends_with(".stl") ? stl(mesh) : ply(mesh), access);
}

}  // namespace fanlight
