// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/survey/echo_sheets.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

/// How a sheet lies to what is found beside it, as a body before a wall does, and the wall behind it.
struct SheetBorders {
  int all = 0;  ///< pairs of neighbouring profiles at its border
  int before =
      0;  ///< pairs of neighbouring profiles at its border: the other one shows a step farther off only
  int behind = 0;  ///< pairs of which the other one shows a nearer step that this one does not have

  /// Of the pairs, those before, with `neutral` pairs more that count by half: 0 behind all, 1 before all.
  double before_share(double neutral) const { return (before + neutral / 2) / (before + behind + neutral); }
};

/// `least_step`: of a step beside the sheet that counts, grey levels.
SheetBorders borders_of(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet,
                        float least_step);

}  // namespace fanlight
