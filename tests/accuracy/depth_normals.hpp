#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "proto/scene.hpp"
#include "tests/accuracy/depth_truth.hpp"

namespace fanlight::test {

/// The normal that pass 2 lights a pixel with, from its depth map, in the transducer frame; nothing where the
/// pixel has no surface.
class DepthNormals {
 public:
  /// `step_mm`: neighbours that differ by more are on another surface (central alone).
  DepthNormals(std::span<const float> depth_mm, PictureSize size, const PixelRays& rays, Normals kind,
               double step_mm)
      : depth_mm_(depth_mm), size_(size), rays_(rays), kind_(kind), step_mm_(step_mm) {}

  std::optional<glm::dvec3> at(int column, int row) const;

 private:
  /// Depth of a pixel, or nothing outside the picture or where there is no surface.
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

/// Angle between the normals shown and the true ones, deg, of each pixel that shows the true surface.
std::vector<double> normal_errors_deg(const DepthNormals& normals, std::span<const float> shown_mm,
                                      std::span<const PixelTruth> truth, const PixelRays& rays,
                                      PictureSize size, const KnownSurface& surface);

}  // namespace fanlight::test
