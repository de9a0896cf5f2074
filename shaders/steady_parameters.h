// SPDX-License-Identifier: Apache-2.0
// Parameters of the temporal filter of pass 2 (renderer/ALGORITHM.md, pass 2): where the pixels of this
// volume's depth map and of the earlier one lie. Lengths in mm. The frame of a map is that of its view: to
// the right, down, and the depth below the view plane.
#ifndef FANLIGHT_SHADERS_STEADY_PARAMETERS_H
#define FANLIGHT_SHADERS_STEADY_PARAMETERS_H
#include "seam_parameters.h"
#include "vector_types.h"

// What the last step of the filter does.
#define FANLIGHT_TEMPORAL_ALONE 0   // the map of this volume alone
#define FANLIGHT_TEMPORAL_STEADY 1  // the mean with earlier volumes
#define FANLIGHT_TEMPORAL_SEAM 2    // at the seam of a rolling sweep, in part the map before

// Cells of a map, across or down, at most. A cell is a square of pixels.
#define FANLIGHT_MAP_CELLS 64

FANLIGHT_SHADER_STRUCT(MapView) {
  uint width;  // of the picture
  // First and last column and row of the viewport; last < first: it has none.
  int left;
  int top;
  int right;
  int bottom;
  vec2 middle;         // of the viewport: column and row
  float scale_at_0;    // side of a pixel in the body, mm: scale_at_0 + scale_per_mm * depth
  float scale_per_mm;  // 0 in parallel projection
  int cell_side;       // pixels
  int cells_across;    // 0 without a viewport
  int cells_down;
}
FANLIGHT_SHADER_STRUCT_END

FANLIGHT_SHADER_STRUCT(SteadyParameters) {
  MapView now;
  MapView earlier;
  // The axes and the origin of the frame of `now` in the frame of `earlier`, where the body has not moved.
  vec3 right;
  vec3 down;
  vec3 forward;
  vec3 origin;
  vec3 pivot;           // about which a motion turns, in the frame of `earlier`
  float added_volumes;  // 1, or 0 where the volume of `now` is part of the earlier map
  float most_volumes;   // in the mean of a pixel
  SeamParameters seam;  // FANLIGHT_TEMPORAL_SEAM only
}
FANLIGHT_SHADER_STRUCT_END

#ifndef __cplusplus
layout(binding = FANLIGHT_BINDING_STEADY_PARAMETERS, scalar) uniform SteadyParametersBlock {
  SteadyParameters steady_parameters[1];
};
#define steady steady_parameters[FANLIGHT_PARAMETER_INDEX]
#endif

#endif
