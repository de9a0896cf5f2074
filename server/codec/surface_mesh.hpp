// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "proto/base/file_replacement.hpp"
#include "proto/base/result.hpp"
#include "proto/model/picture.hpp"

namespace fanlight {

/// The surface of a picture as triangles, in the transducer frame, mm. What the picture does not show is not
/// there: a mesh of what one camera sees, with a hole where the surface hides a part of itself.
struct SurfaceMesh {
  std::vector<std::array<float, 3>> points_mm;
  std::vector<std::array<float, 3>> normals;            ///< unit, towards the camera; of each point
  std::vector<std::array<std::uint8_t, 3>> colours;     ///< sRGB, as lit, grey of glass; of each point
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise as seen by the camera
};

/// A point for each pixel with a surface, and two triangles between four neighbours, or one between three.
/// None across a step in depth of more than 2.5 times what a surface at 45 degrees has, where one part hides
/// another. Points without a triangle are left out.
SurfaceMesh mesh_of(const Picture& picture);

/// Binary PLY with normals and colours, or binary STL (.stl), which has a normal for each triangle and no
/// colours. Written whole or not at all; replaces a file of this name. kInvalidArgument for another ending.
Result<void> check_mesh_path(const std::string& path);
Result<void> write_mesh(const std::string& path, const SurfaceMesh& mesh, FileAccess access = {});

}  // namespace fanlight
