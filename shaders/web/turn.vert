// SPDX-License-Identifier: Apache-2.0
// A surface as it would be seen from another view: its depth map as a mesh, whose vertices are the pixels, projected to
// the pixels of the other view. Triangles that bridge a step of the surface are drawn as holes, behind everything else.
#include "bindings.h"
#include "web/turned_surface.h"

uniform highp usampler2D depths;       // of the view that was cast, in units of depth_unit
uniform highp usampler2D certainties;  // as in alpha of the colours of pass 1
uniform float depth_unit;              // mm
// The view that was cast: its middle, and mm per pixel in the view plane and for each mm of depth.
uniform vec2 from_centre;
uniform float from_pixel;
uniform float from_pixel_per_mm;
// From right, down and depth in that view to the same in the other, mm.
uniform mat4 turn;
// The other view, and its size in pixels.
uniform vec2 to_centre;
uniform float to_pixel;
uniform float to_pixel_per_mm;
uniform vec2 to_size;
uniform float start;   // nothing nearer is shown, mm
uniform float behind;  // how far another cast goes before this one where both show a surface, mm
uniform int holes;     // 1: the triangles are holes

out highp vec2 surface;  // depth in the other view, mm, or kHole; certainty, 0 to 1

const float kFarthest = 2000.0;  // mm

void main() {
  int across = textureSize(depths, 0).x;
  ivec2 pixel = ivec2(gl_VertexID % across, gl_VertexID / across);
  float depth = float(texelFetch(depths, pixel, 0).r) * depth_unit;
  vec2 across_mm = (vec2(pixel) - from_centre) * (from_pixel + from_pixel_per_mm * depth);
  vec3 seen = (turn * vec4(across_mm, depth, 1.0)).xyz;
  float scale = to_pixel + to_pixel_per_mm * seen.z;
  vec2 at = to_centre + seen.xy / max(scale, 1e-6) + 0.5;
  float far = holes != 0 ? 0.999 : (seen.z + behind) / kFarthest;
  // Before the nearest depth that is shown, and behind the eye, it is clipped.
  bool shown = scale > 0.0 && seen.z >= start;
  gl_Position = vec4(2.0 * at / to_size - 1.0, shown ? 2.0 * far - 1.0 : -2.0, 1.0);
  float certainty = float(texelFetch(certainties, pixel, 0).r) / 255.0;
  surface = holes != 0 ? vec2(kHole, 0.0) : vec2(seen.z, certainty);
}
