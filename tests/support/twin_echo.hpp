#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "proto/scene.hpp"
#include "proto/volume.hpp"

namespace fanlight::test {

/// The echo at a point of the transducer frame, 0 to 1: trilinear between the nearest pixels of the nearest
/// frames, wherever their angles lie. Nothing where nothing was scanned, and near the border of a sector,
/// where pixels without an echo (or pass 0's window over them) have a share in it.
std::optional<double> twin_echo(const Scene::Speckle& speckle, const Volume& prepared, const glm::dvec3& at);

}  // namespace fanlight::test
