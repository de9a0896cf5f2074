// SPDX-License-Identifier: Apache-2.0
// Pass 3, outlines by coverage, as outline.comp.
#include "web/received_surface.h"

#include "web/lit_texture.h"

bool may_have_outline(ivec2 pixel) {
  return true;
}
#include "outline_colour.h"

out vec4 colour;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 outlined = outlined_colour(pixel);
  colour = vec4(outlined.w > 0.0 ? outlined.rgb : lit_at(pixel), 1.0);
}
