// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/cut_mask.hpp"

namespace fanlight::test {

/// CPU twin of shaders/cut_mask.h and CutMask: each corner by its own point-in-polygon test.
class TwinCuts {
 public:
  TwinCuts(const Scene& scene, const Volume& volume);

  /// 0 where all around a point is kept, 1 where all is cut.
  double share(const glm::dvec3& at) const;
  bool is_cut(const glm::dvec3& at) const { return share(at) >= 0.5; }
  double cell_mm() const { return grid_.cell_mm; }

 private:
  bool cuts_corner(const glm::dvec3& corner) const;

  const CutList& list_;
  CutGrid grid_;
};

}  // namespace fanlight::test
