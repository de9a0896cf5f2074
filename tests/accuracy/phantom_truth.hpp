// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "acquisition/phantom/phantom_source.hpp"
#include "proto/model/volume.hpp"
#include "tests/support/known_surface.hpp"

namespace fanlight::test {

/// The relief of the simulated probe, at time 0.
class ReliefSurface final : public KnownSurface {
 public:
  explicit ReliefSurface(const PhantomScene& scene) : scene_(scene) {}
  double below_mm(const glm::dvec3& at) const override;
  std::optional<double> entry_mm(const PixelRay& ray, double from_mm, double to_mm) const override;

 private:
  double surface_mm(double x_mm, double z_mm) const { return scene_.surface_depth_mm(x_mm, z_mm, 0); }

  const PhantomScene& scene_;
};

/// The bodies of the simulated probe at one instant.
class BodySurface final : public KnownSurface {
 public:
  BodySurface(const BodyScene& scene, double time_s) : scene_(scene), poses_(scene.poses_at(time_s)) {}
  double below_mm(const glm::dvec3& at) const override;
  std::optional<double> entry_mm(const PixelRay& ray, double from_mm, double to_mm) const override;

 protected:
  /// About half of a cell of the grid, at whose borders the gradient jumps.
  double normal_offset_mm() const override { return 0.4; }

 private:
  const BodyScene& scene_;
  BodyScene::Poses poses_;
};

/// Throws std::runtime_error.
std::unique_ptr<PhantomSource> made_phantom(const PhantomSource::Config& config);

/// What the source shows at that time. A relief is always that at time 0. The source must outlive it.
std::unique_ptr<KnownSurface> surface_of(const PhantomSource& source, double time_s = 0);

/// All frames of the sweep that begins where the source stands: at first the first one. Throws
/// std::runtime_error.
Volume next_sweep(PhantomSource& source);

}  // namespace fanlight::test
