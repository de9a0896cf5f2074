// SPDX-License-Identifier: Apache-2.0
// Parameters of passes 2 and 3 (renderer/ALGORITHM.md, passes 2 and 3). Lengths in mm, in the view frame:
// right, up, and depth below the view plane or height (-depth).
#ifndef FANLIGHT_SHADERS_LIGHT_PARAMETERS_H
#define FANLIGHT_SHADERS_LIGHT_PARAMETERS_H
#include "vector_types.h"

#define FANLIGHT_MAP_POINTS 4
#define FANLIGHT_MAX_LAMPS 3

FANLIGHT_SHADER_STRUCT(LightParameters) {
  uint width;  // of the picture
  uint height;
  // The viewport: its first and last column and row (last < first: no viewport), and its centre. Depths exist
  // only here.
  int view_left;
  int view_top;
  int view_right;
  int view_bottom;
  vec2 centre;
  float pixel;  // side of a pixel in the body at the depth where the view scale is 1, mm
  // View scale at a depth: view_scale_at_0 + view_scale_per_mm * depth. 1 at the target.
  float view_scale_at_0;
  float view_scale_per_mm;
  float eye_height;  // perspective: of the eye above the view plane

  float same_surface;  // largest step of one surface, mm
  int islands_radius;  // windows span 2 r + 1 pixels
  int holes_radius;
  int filter_radius;
  float filter_fall;      // Gaussian: 1 / (2 sigma^2), per pixel^2
  float sum_units;        // moving average: units of a sum per mm (mean_rows.comp)
  int confidence_counts;  // 1: weights are given by the confidence, 0: all weights are 1
  // The part of the picture that the moving average computes: its first column and row, and those behind its
  // last ones.
  int smooth_left;
  int smooth_top;
  int smooth_right;
  int smooth_bottom;

  // The lights that are on.
  int lamps;                                 // how many, 0 to FANLIGHT_MAX_LAMPS
  int directional;                           // 1: directional lights, 0: point lights
  vec3 lamp_places[FANLIGHT_MAX_LAMPS];      // of point lights: right, up, height
  vec3 lamp_directions[FANLIGHT_MAX_LAMPS];  // towards directional lights, length 1
  vec3 lamp_colours[FANLIGHT_MAX_LAMPS];     // linear, times their strengths
  vec3 lamp_distances;                       // of directional lights, one a component: for the penumbra
  vec3 light_colour;                         // of the ambient light, linear, 0 to 1
  vec3 material;                             // colour of the surface under white light, linear, 0 to 1
  float ambient;
  float diffuse;
  float specular;
  float shininess;
  int central_normals;  // 1: central differences, 0: three neighbouring pixels
  float shadow;         // fraction of the direct light that remains in a shadow; 1: no shadows
  float softness;       // radius of the light, mm; 0: hard shadows
  float shadow_top;     // upper limit of the heights of surfaces, where shadow rays end

  // Soft light.
  float occlusion;        // share of the ambient light that hollows may lose
  float occlusion_reach;  // radius of the neighbourhood that hides it, mm
  vec3 scattered;         // share of the matt light that enters the surface, by colour
  int scatter_radius;     // of the window, in places of soft_light.h
  float scatter_fall;     // Gaussian: 1 / (2 sigma^2), per mm^2
  float glow;             // share of the light from behind that a thin part lets through
  float glow_reach;       // thickness that lets 1 / e of it through, mm
  float fade_reach;       // how far before a border without a surface beyond the light fades, mm; 0: not
  float rim;              // light on what turns away from the viewer
  float half_from;        // depth beyond which the light falls off, mm
  float halves_per_mm;    // how often it falls to half in a mm beyond; 0: it does not
  vec3 haze;              // light where there is no surface, and the least light of one, linear
  float exposure;         // factor of all light
  int film;               // 1: the film tone, 0: linear

  float glass;            // 0: the surface is opaque, 1: it is glass (glass.h)
  int show;               // FANLIGHT_SHOW_..., inside the viewport
  int colours_from_left;  // outside it: shows the colours of the pixel this number of columns to the left
  float depth_white;      // depth map: the depth that is white, mm, and 1 / (depth of black - depth of white)
  float depth_scale;

  int outline_radius;     // pass 3: windows span 2 r + 1 pixels; 0: outlines stay as they are
  float outline_fall;     // pass 3: how weights fall with the square of the distance, per pixel^2
  float outline_scale;    // pass 3: k of renderer/ALGORITHM.md, outlines: distance = k (share - 1/2) / offset
  int mean;               // pass 3: 1: 2 x 2 mean
  float diffusion_scale;  // pass 3: 1 / conductance
  int map_colours;        // pass 3: 1: colour map, by brightness, linear between the points
  vec3 map_points[FANLIGHT_MAP_POINTS];
}
FANLIGHT_SHADER_STRUCT_END

#if defined FANLIGHT_WEB
uniform LightParameters lighting;
#elif !defined __cplusplus
layout(binding = FANLIGHT_BINDING_LIGHT_PARAMETERS, scalar) uniform Parameters {
  LightParameters parameters[1];
};
#define lighting parameters[FANLIGHT_PARAMETER_INDEX]
#endif

#endif
