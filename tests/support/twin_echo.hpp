// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"

namespace fanlight::test {

/// The echo at a point of the transducer frame (mm), 0 to 1: trilinear interpolation between the pixels of
/// the two frames whose angles enclose the point. nullopt where nothing was scanned, and near the border of a
/// sector, where pixels without an echo, or windows of pass 0 with such pixels, would contribute.
std::optional<double> twin_echo(const Scene::Speckle& speckle, const Volume& prepared, const glm::dvec3& at);

/// Whether a point lies between the first and the last frame and within their borders, whatever its voxels.
bool is_within_frames(const Scene::Speckle& speckle, const Volume& prepared, const glm::dvec3& at);

/// The frame coordinate of an angle among the frames by ascending angle: 0 for the first frame, a fraction
/// between two. nullopt outside them.
std::optional<double> frame_coordinate(const Volume& volume, double angle_rad);

}  // namespace fanlight::test
