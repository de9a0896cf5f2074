// SPDX-License-Identifier: Apache-2.0
// What the temporal filter of pass 2 finds before it averages: the motion of the body since the earlier map,
// and where the two maps agree (renderer/ALGORITHM.md, pass 2). Cells are numbered along their rows,
// FANLIGHT_MAP_CELLS a row.
#ifndef FANLIGHT_SHADERS_MAP_ALIGNMENT_H
#define FANLIGHT_SHADERS_MAP_ALIGNMENT_H
#include "steady_parameters.h"

FANLIGHT_SHADER_STRUCT(MapAlignment) {
  // map_motion.comp: the axes and the origin of the frame of `now` in the frame of `earlier`, as the body has
  // moved.
  vec3 right;
  vec3 down;
  vec3 forward;
  vec3 origin;
  uint found;  // 1: the motion is known; 0: the maps have too little in common
  // map_cells.comp: mean depth of each cell, mm, FANLIGHT_NO_SURFACE where it does not show one surface.
  float now_cells[FANLIGHT_MAP_CELLS * FANLIGHT_MAP_CELLS];
  float earlier_cells[FANLIGHT_MAP_CELLS * FANLIGHT_MAP_CELLS];
  // map_differences.comp, for each cell of `now`: the mean of (depth now - depth before), mm, along the rays
  // of `earlier`; and its weight, 0 where it says nothing.
  vec2 differences[FANLIGHT_MAP_CELLS * FANLIGHT_MAP_CELLS];
  // Slopes of the earlier surface there: mm deeper for each mm to the right and down.
  vec2 slopes[FANLIGHT_MAP_CELLS * FANLIGHT_MAP_CELLS];
  // mm along the rays of `now` for each mm along those of `earlier`.
  float stretch[FANLIGHT_MAP_CELLS * FANLIGHT_MAP_CELLS];
  // map_agreement.comp, for each cell of `now`: its two figures and the roughness; and what is added to 1 /
  // volumes of the earlier map, as its mean may be that of another place.
  vec3 figures[FANLIGHT_MAP_CELLS * FANLIGHT_MAP_CELLS];
  float doubt[FANLIGHT_MAP_CELLS * FANLIGHT_MAP_CELLS];
}
FANLIGHT_SHADER_STRUCT_END

#endif
