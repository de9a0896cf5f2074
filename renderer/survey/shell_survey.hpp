// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <stop_token>

#include "proto/model/volume.hpp"
#include "renderer/parameters/near_tissue.hpp"
#include "renderer/survey/surface_survey.hpp"

namespace fanlight {

/// A closed bright shell, such as a fetal skull: a sheet behind which the echo is darker, bent towards the
/// probe, and behind it a bright line before which it is darker, bent away. Both lie near one sphere.
struct ShellSurvey {
  SurfaceSurvey near_wall;  ///< the inner side of its wall next to the probe
  NearTissue before;        ///< ends just before that wall; beside the shell as deep as at its border
  double radius_mm = 0;     ///< of the sphere
};

/// Deterministic; allocates. nullopt: there is none, or a stop was requested. Precondition: the volume has
/// frames, sorted by angle.
std::optional<ShellSurvey> find_shell(const Volume& volume, const std::stop_token& stop = {});

}  // namespace fanlight
