// SPDX-License-Identifier: Apache-2.0
// Pass 2, soft light, as soft_light.comp.
#include "web/received_surface.h"

#include "soft_surface.h"

uniform highp sampler2D normals;  // of prepare.frag
uniform highp sampler2D places;   // of prepare_soft.frag

layout(location = 0) out vec4 direct;
layout(location = 1) out vec4 scattered;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 kept = texelFetch(places, at, 0);
  int which = int(kept.x);
  Place place;
  place.pixel = 2 * at + ivec2(which & 1, which >> 1);
  place.depth = filtered_depth(place.pixel);
  place.normal = texelFetch(normals, place.pixel, 0).xyz;
  place.sky = kept.y;
  place.known = kept.z;
  SoftLight light = soft_light_of(place);
  direct = vec4(light.direct, light.sky);
  scattered = vec4(light.scattered, light.depth);
}
