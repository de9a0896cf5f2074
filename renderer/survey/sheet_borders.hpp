// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/survey/echo_sheets.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

/// How a sheet from dark to bright relates to what lies beside it: a body stands before a wall, and the wall
/// lies behind the body. Lengths across the beams, at the depth of the sheet.
struct SheetBorders {
  double area_mm2 = 0;   ///< of the sheet
  double all_mm = 0;     ///< of its border
  double fan_mm = 0;     ///< where the fan ends
  double before_mm = 0;  ///< beside it there is fluid, and then a sheet that is farther from the probe
  double behind_mm = 0;  ///< beside it there is a nearer sheet, which it does not lie under itself
};

struct BorderLevels {
  float least_step = 0;  ///< of a sheet beside it, grey levels
  double fluid = 0;      ///< the brightest level of fluid
};

SheetBorders sheet_borders(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet,
                           const BorderLevels& levels);

}  // namespace fanlight
