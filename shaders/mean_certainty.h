// SPDX-License-Identifier: Apache-2.0
// The certainty that dims a pixel. Shared by light.comp and web/prepare.frag. The includer has declared the
// parameters as `lighting`, and
//   uint pass1_colour(ivec2 pixel)   packed RGBA8 of a pixel in the viewport, with the certainty
#ifndef FANLIGHT_SHADERS_MEAN_CERTAINTY_H
#define FANLIGHT_SHADERS_MEAN_CERTAINTY_H
#include "certainty.h"

// How certain the surface is: the mean of the rays about a pixel, since speckle makes it uneven. 0 where none
// of them met a surface: the pixel is in a hole that was filled.
float certainty_about(ivec2 pixel) {
  ivec2 first = ivec2(lighting.view_left, lighting.view_top);
  ivec2 last = ivec2(lighting.view_right, lighting.view_bottom);
  float sum = 0.0;
  float met = 0.0;
  [[unroll]] for (int each = 0; each < 9; ++each) {
    ivec2 beside = ivec2(each % 3, each / 3) - 1;
    uint colour = pass1_colour(clamp(pixel + beside, first, last));
    sum += certainty_of(colour);
    met += has_surface(colour) ? 1.0 : 0.0;
  }
  return sum / max(met, 1.0);
}

#endif
