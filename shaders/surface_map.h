// SPDX-License-Identifier: Apache-2.0
// Depth maps of pass 2: height x width of the picture, top row first, valid inside the viewport. The
// includer has declared the parameters as `lighting`.
#ifndef FANLIGHT_SHADERS_SURFACE_MAP_H
#define FANLIGHT_SHADERS_SURFACE_MAP_H

bool in_view(ivec2 pixel) {
  return pixel.x >= lighting.view_left && pixel.y >= lighting.view_top && pixel.x <= lighting.view_right &&
         pixel.y <= lighting.view_bottom;
}

// The window about a pixel, clipped to the viewport: first column and row, last column and row.
ivec4 window_about(ivec2 pixel, int radius) {
  return ivec4(max(pixel - radius, ivec2(lighting.view_left, lighting.view_top)),
               min(pixel + radius, ivec2(lighting.view_right, lighting.view_bottom)));
}

uint index_of(ivec2 pixel) {
  return uint(pixel.y) * lighting.width + uint(pixel.x);
}

// Both depths exist and differ by at most `same_surface` mm.
bool same_surface(float a, float b) {
  return a >= 0.0 && b >= 0.0 && abs(a - b) <= lighting.same_surface;
}

#endif
