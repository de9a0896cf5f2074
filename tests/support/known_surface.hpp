// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "tests/support/pixel_rays.hpp"

namespace fanlight::test {

/// Tissue in fluid with an analytically known surface: the intersection of rays with it, and its normals.
/// Points are in the transducer frame, mm.
class KnownSurface {
 public:
  virtual ~KnownSurface() = default;

  /// Depth of a point below the surface along its normal, mm; negative in the fluid. Exact at the surface;
  /// away from it a first-order approximation (value over gradient) is allowed.
  virtual double below_mm(const glm::dvec3& at) const = 0;

  /// Depth at which a ray first passes from fluid into tissue between two depths; empty if it does not.
  virtual std::optional<double> entry_mm(const PixelRay& ray, double from_mm, double to_mm) const;

  /// Unit normal at a point of the surface. It points into the fluid.
  glm::dvec3 normal(const glm::dvec3& at) const;

 protected:
  /// Half of the distance over which the normal's gradient is measured.
  virtual double normal_offset_mm() const { return 1e-3; }
};

/// Grey levels of a surface in a frame: a step that is blurred by an isotropic Gaussian point spread.
struct KnownEcho {
  double fluid_grey = 10;
  double tissue_grey = 110;
  double spread_mm = 0.3;  ///< standard deviation of the point spread
  double range_db = 0;     ///< of log compression: speckle adds to a grey level; 0: linear, it multiplies

  /// Full width at half maximum of a thin bright surface in fluid, whose front half lies at the surface; 0:
  /// tissue fills what is below.
  double thickness_mm = 0;

  double grey(double below_mm) const;
  /// With speckle, whose factors have the mean 1.
  double grey(double below_mm, double factor) const;
  double contrast() const { return tissue_grey - fluid_grey; }
};

/// As a scanner shows it: 60 dB from black to white, tissue 35 dB above the fluid. The grey levels are
/// blurred: the edge is that of the picture. (A beam that blurs before the compression moves it by about one
/// standard deviation towards the fluid.)
inline constexpr KnownEcho kLogEcho{.fluid_grey = 5, .tissue_grey = 150, .spread_mm = 0.3, .range_db = 60};

/// A half space. Its surface is perpendicular to y, then rotated about x, then about z.
class KnownPlane final : public KnownSurface {
 public:
  KnownPlane(const glm::dvec3& through, double about_x_deg, double about_z_deg);
  double below_mm(const glm::dvec3& at) const override;
  std::optional<double> entry_mm(const PixelRay& ray, double from_mm, double to_mm) const override;

 private:
  glm::dvec3 through_;
  glm::dvec3 inwards_;
};

class KnownSphere final : public KnownSurface {
 public:
  KnownSphere(const glm::dvec3& centre, double radius_mm) : centre_(centre), radius_mm_(radius_mm) {}
  double below_mm(const glm::dvec3& at) const override;
  std::optional<double> entry_mm(const PixelRay& ray, double from_mm, double to_mm) const override;

 private:
  glm::dvec3 centre_;
  double radius_mm_;
};

/// A smooth height field: waves of 22 to 27 mm length with slopes up to about 40 deg.
class KnownRelief final : public KnownSurface {
 public:
  explicit KnownRelief(double mean_depth_mm) : mean_depth_mm_(mean_depth_mm) {}
  double below_mm(const glm::dvec3& at) const override;

 private:
  double mean_depth_mm_;
};

}  // namespace fanlight::test
