// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <stop_token>
#include <vector>

#include "proto/model/echo_levels.hpp"
#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/near_tissue.hpp"
#include "renderer/survey/echo_sheets.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

/// What a coarse look at a volume finds: a body in fluid; where there is none, the best sheet at which the
/// echo steps from dark to bright, or else from bright to dark.
struct SurfaceSurvey {
  EdgeSign sign = EdgeSign::kDarkToBright;
  std::vector<glm::dvec3> points;  ///< of the sheet, transducer frame, mm
  glm::dvec3 centre{};             ///< their mean
  glm::dvec3 normal{};             ///< mean direction of the sheet's near side, unit
  double yaw_deg = 0;              ///< of a camera that looks at it, as far as possible at a right angle
  double pitch_deg = 0;            ///< of the same
  glm::dvec3 view{};               ///< the direction in which it looks, unit
  double flatness = 0;             ///< 1 for a plane, less for a sheet that turns its near side elsewhere
  double covered_share = 0;        ///< of the profiles
  double contrast = 0;             ///< median step in grey levels
  double clutter = 0;              ///< median size of all steps
  double threshold = 0;            ///< of the step, which finds the sheet best where it is looked for first
  double start_mm = 0;             ///< depth along `view` from the origin, from which it is looked for
  double found_share = 0;          ///< of the sheet's profiles, by that threshold, within 4 mm
  bool is_body = false;            ///< of a body that stands before other sheets, with fluid between them
  double at_fan_share = 0;         ///< of the border of a body, where the fan ends
  std::vector<glm::dvec3> behind;  ///< points of the best other sheet, where this is a body
};

/// How large and whole a sheet is, 0 to 1: 1 for a plane in every beam that is found first.
double clarity(const SurfaceSurvey& survey);

/// How a sheet lies, and how a search finds it. Precondition: it is not empty.
SurfaceSurvey survey_of(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet);

/// Deterministic. nullopt: no sheet stands out of the clutter, or a stop was requested: it ends within a
/// fraction of its time then. `levels`: of the volume; where they are not known no sheet is a body.
/// `removed`: near tissue in which no sheet is looked for. Precondition: the volume has frames, sorted by
/// angle.
std::optional<SurfaceSurvey> find_surface(const Volume& volume, const EchoLevels& levels,
                                          const std::stop_token& stop = {},
                                          const std::optional<NearTissue>& removed = {});

}  // namespace fanlight
