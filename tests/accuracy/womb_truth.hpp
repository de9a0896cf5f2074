// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "acquisition/phantom/phantom_source.hpp"
#include "proto/model/volume.hpp"
#include "tests/support/pixel_rays.hpp"
#include "tests/support/scanned_fan.hpp"

namespace fanlight::test {

/// A scene of bodies at rest, scanned once.
struct ScannedWomb {
  std::unique_ptr<PhantomSource> source;
  Volume volume;

  ScannedFan fan() const;
};

/// `options`: of the simulated probe, such as "scene=womb,seed=3". Throws std::runtime_error.
ScannedWomb scanned_womb(std::string_view options);

/// The fetus at time 0: head, hand and cord. The source must outlive it.
class Fetus {
 public:
  explicit Fetus(const PhantomSource& source)
      : source_(source), poses_(source.bodies()->poses_at(0)), geometry_(source.description().geometry) {}

  BodyScene::Found at(const glm::dvec3& point) const {
    return source_.bodies()->found(poses_, {point.x, point.y, point.z});
  }

  /// Whether the surface within `within_mm` of a point is the fetus's.
  bool is_at(const glm::dvec3& point, double within_mm) const;

  /// Depth at which a ray meets the fetus, where it meets it first behind the near wall and within the fan.
  std::optional<double> met_mm(const PixelRay& ray, double from_mm, double to_mm) const;

 private:
  bool is_scanned(const glm::dvec3& point) const;

  const PhantomSource& source_;
  BodyScene::Poses poses_;
  const FanGeometry& geometry_;
};

}  // namespace fanlight::test
