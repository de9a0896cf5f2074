// SPDX-License-Identifier: Apache-2.0
// What shading needs of each pixel of a surface, wherever the light is: its normal, and in alpha the certainty that dims
// it.
#include "web/received_surface.h"

#include "surface_light.h"

#ifdef FANLIGHT_TURNED
uint pass1_colour(ivec2 pixel) {
  return uint(255.0 * texelFetch(turned, pixel, 0).g + 0.5) << 24;
}
#else
uniform highp usampler2D certainties;  // as in alpha of the colours of pass 1

uint pass1_colour(ivec2 pixel) {
  return texelFetch(certainties, pixel, 0).r << 24;
}
#endif
#include "mean_certainty.h"

out vec4 prepared;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float depth = filtered_depth(pixel);
  prepared = depth < 0.0 ? vec4(0.0, 0.0, 1.0, 0.0) : vec4(normal_at(pixel, depth), certainty_about(pixel));
}
