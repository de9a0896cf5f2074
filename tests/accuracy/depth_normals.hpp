// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "proto/model/scene.hpp"
#include "tests/accuracy/depth_truth.hpp"

namespace fanlight::test {

/// The normals of pass 2, computed from a depth map as light.comp does, in the transducer frame. nullopt: no
/// surface.
class DepthNormals {
 public:
  /// `step_mm`: neighbours that differ by more are on another surface (central normals only). Keeps
  /// references to the depths and the rays.
  DepthNormals(std::span<const float> depth_mm, PictureSize size, const PixelRays& rays, Normals kind,
               double step_mm)
      : depth_mm_(depth_mm), size_(size), rays_(rays), kind_(kind), step_mm_(step_mm) {}

  std::optional<glm::dvec3> at(int column, int row) const;

 private:
  /// Depth of a pixel; nullopt outside the picture or without a surface.
  std::optional<double> depth_mm(int column, int row) const;
  std::optional<double> neighbour_mm(int column, int row, double depth_mm) const;
  glm::dvec3 place(int column, int row, double depth_mm) const;
  glm::dvec3 tangent(int column, int row, int right, int down) const;

  std::span<const float> depth_mm_;
  PictureSize size_;
  const PixelRays& rays_;
  Normals kind_;
  double step_mm_;
};

/// Angles between rendered and true normals, deg, one for each pixel whose surface is found.
std::vector<double> normal_errors_deg(const DepthNormals& normals, std::span<const float> shown_mm,
                                      std::span<const PixelTruth> truth, const PixelRays& rays,
                                      PictureSize size, const KnownSurface& surface);

}  // namespace fanlight::test
