// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/cast_parameters.hpp"
#include "shaders/near_tissue.h"

namespace fanlight {

/// Where the tissue before the fluid ends, such as the belly's wall and a placenta: a smooth map over the
/// fan. It lies in the fluid, behind that tissue and before what is behind the fluid.
struct NearTissue {
  static constexpr std::uint32_t kAcross =
      FANLIGHT_NEAR_ENDS;  ///< control points from the first column to the last
  static constexpr std::uint32_t kAround =
      FANLIGHT_NEAR_ENDS;  ///< control points from the first angle to the last

  double first_angle_rad = 0;
  double last_angle_rad = 0;
  /// In rows of a frame, control points in order of angle, then of column.
  std::array<float, std::size_t{kAcross} * kAround> end_row{};

  /// Linear between the control points; beyond the outermost ones as at them.
  double end_row_at(const FanGeometry& geometry, double column, double angle_rad) const;

  bool operator==(const NearTissue&) const = default;
};

/// What a search for near tissue came to.
struct NearTissueSearch {
  bool done = false;                ///< false: no scene asked for it
  std::optional<NearTissue> found;  ///< nullopt: no fluid behind near tissue was found
  bool operator==(const NearTissueSearch&) const = default;
};

/// Where rays start to show anything, where the scene removes near tissue: each where it first leaves it. For
/// a grid of rays over the picture; those that do not meet the fan take the values of their neighbours.
/// Without near tissue, or where the scene shows it, all values are -FANLIGHT_MAX_DEPTH. Does not
/// allocate.
shaders::NearTissueParameters near_tissue_parameters(const Scene& scene, const shaders::CastParameters& rays,
                                                     const FanGeometry& geometry, const VolumeExtent& volume,
                                                     const std::optional<NearTissue>& near);

}  // namespace fanlight
