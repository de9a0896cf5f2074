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

void main() {
  lit = vec4(shown_surface(ivec2(gl_FragCoord.xy)), 1.0);
}
