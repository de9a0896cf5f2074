// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/cast_parameters.hpp"
#include "shaders/near_tissue.h"

namespace fanlight {

/// Where the tissue next to the probe ends, such as the belly's wall and a placenta: a smooth map over the
/// fan. It lies in the fluid behind that tissue, or just before a bone.
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
  // What was looked for; nothing where no scene asked for it.
  bool for_fluid = false;
  bool for_bone = false;
  std::optional<NearTissue> found;  ///< nullopt: its end was not found
  bool ends_at_bone = false;        ///< of `found`; otherwise in fluid

  bool done() const { return for_fluid || for_bone; }

  /// What a scene removes; nullptr: nothing.
  const NearTissue* removed_by(const Scene::Near& near) const;
  /// What a picture of the scene shows of it.
  NearTissueState state(const Scene::Near& near) const;
  bool operator==(const NearTissueSearch&) const = default;
};

/// Where rays start to show anything, where the scene removes near tissue: each where it first leaves it. For
/// a grid of rays over the picture; those that do not meet the fan take the values of their neighbours.
/// Without near tissue, or where the scene shows it, all values are -FANLIGHT_MAX_DEPTH. Does not
/// allocate.
shaders::NearTissueParameters near_tissue_parameters(const Scene& scene, const shaders::CastParameters& rays,
                                                     const FanGeometry& geometry, const VolumeExtent& volume,
                                                     const NearTissueSearch& near);

/// PictureStamp::near_end_mm.
double near_end_mm(const Scene& scene, const FanGeometry& geometry, const VolumeExtent& volume,
                   const NearTissueSearch& near);

}  // namespace fanlight
