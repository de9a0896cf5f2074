#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "tests/support/pixel_rays.hpp"

namespace fanlight::test {

/// Tissue in fluid with a surface that is known: what frames show of it, and where each ray meets it. Points
/// are in the transducer frame, mm.
class KnownSurface {
 public:
  virtual ~KnownSurface() = default;

  /// Depth of a point below the surface along its normal, negative in the fluid; exact at the surface, to
  /// first order (distance over gradient) away from it.
  virtual double below_mm(const glm::dvec3& at) const = 0;

  /// Depth at which a ray first goes from fluid into tissue, between two depths.
  virtual std::optional<double> entry_mm(const PixelRay& ray, double from_mm, double to_mm) const;

  /// Unit vector into the fluid at a point of the surface.
  glm::dvec3 normal(const glm::dvec3& at) const;
};

/// What a frame shows of it, grey levels: a step blurred by a point spread alike in every direction.
struct KnownEcho {
  double fluid_grey = 10;
  double tissue_grey = 110;
  double spread_mm = 0.3;  ///< standard deviation

  double grey(double below_mm) const;
  double contrast() const { return tissue_grey - fluid_grey; }
};

/// A half space whose surface is turned about x, then about z.
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

/// A smooth height field: waves of some 20 mm length, steepest about 40 deg.
class KnownRelief final : public KnownSurface {
 public:
  explicit KnownRelief(double mean_depth_mm) : mean_depth_mm_(mean_depth_mm) {}
  double below_mm(const glm::dvec3& at) const override;

 private:
  double mean_depth_mm_;
};

}  // namespace fanlight::test
