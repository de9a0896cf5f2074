// The parameters of passes 2 and 3. Lengths in mm, in the view frame: right, up, and depth or height (-depth).
#ifndef FANLIGHT_SHADERS_LIGHT_PARAMETERS_H
#define FANLIGHT_SHADERS_LIGHT_PARAMETERS_H
#include "vector_types.h"

#define FANLIGHT_MAP_POINTS 4

FANLIGHT_SHADER_STRUCT(LightParameters) {
  uint width;  // of the picture
  uint height;
  // The viewport, where depths are: its first and last pixel in each axis (last < first where there is none), and
  // its centre.
  int view_left;
  int view_top;
  int view_right;
  int view_bottom;
  vec2 centre;
  float pixel;  // side of a pixel in the body, at the depth where view_scale is 1
  // A length across the view is view_scale_at_0 + view_scale_per_mm * depth times what it is there.
  float view_scale_at_0;
  float view_scale_per_mm;
  float eye_height;  // of the eye above the view plane, in perspective

  float steady;  // share of the last volume's depths
  float same_surface;  // depths that differ by more are two surfaces
  int islands_radius;
  int holes_radius;
  int filter_radius;    // the filter's window spans 2 r + 1 pixels
  float filter_fall;    // 1 / (2 sigma^2) of the Gaussian, per pixel^2
  float sum_units;      // of the moving average, per mm; see mean_rows.comp
  int confidence_counts;  // 1: weights by confidence

  vec3 light;            // right, up, height
  vec3 light_direction;  // towards a directional light, length 1
  int directional;       // 1: the light is
  float lamp_distance;   // of a directional light, for the width of its shadows' edges
  vec3 light_colour;     // linear, 0 to 1
  vec3 material;         // colour of the surface under white light, linear, 0 to 1
  float ambient;
  float diffuse;
  float specular;
  float shininess;
  int central_normals;  // 1: from both sides; 0: from three neighbouring pixels
  float shadow;         // share of the direct light left in a shadow; 1 casts none
  float softness;       // radius of the lamp
  float shadow_top;     // no surface lies above this height: a shadow ray may end there

  int show;                 // FANLIGHT_SHOW_..., inside the viewport
  int colours_from_left;    // outside it, the colours of the pixel so many columns to the left
  float depth_white;        // depth map: the depth that is white, and 1 / (black - white)
  float depth_scale;

  int mean;               // 1: 2 x 2 mean in pass 3
  float diffusion_scale;  // 1 / conductance
  int map_colours;        // 1: by brightness, linear between the points
  vec3 map_points[FANLIGHT_MAP_POINTS];
}
FANLIGHT_SHADER_STRUCT_END

#ifndef __cplusplus
layout(binding = FANLIGHT_BINDING_LIGHT_PARAMETERS, scalar) uniform Parameters { LightParameters parameters[1]; };
#define lighting parameters[FANLIGHT_THE_ONLY]
#endif

#endif
