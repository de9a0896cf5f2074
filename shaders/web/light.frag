// SPDX-License-Identifier: Apache-2.0
// Pass 2, light, as light.comp.
#include "web/received_surface.h"

#include "surface_light.h"

uniform highp sampler2D normals;  // of prepare.frag

vec3 surface_normal(ivec2 pixel, float depth) {
  return texelFetch(normals, pixel, 0).xyz;
}

float surface_certainty(ivec2 pixel) {
  return texelFetch(normals, pixel, 0).w;
}
#include "surface_shade.h"

out vec4 lit;

#ifdef FANLIGHT_TURNED
#include "web/turned_surface.h"

// What the view that was cast has not seen.
const vec3 kUnseen = vec3(0.14);
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  lit = vec4(shown_surface(pixel), 1.0);
#ifdef FANLIGHT_TURNED
  if (texelFetch(turned, pixel, 0).r == kHole) lit.rgb = kUnseen;
#endif
}
