// SPDX-License-Identifier: Apache-2.0
// Pass 3, as finish.comp. On the screen row 0 is the bottom row.
#include "web/lit_texture.h"

#include "finish_colour.h"

out vec4 colour;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  colour = vec4(finished_colour(ivec2(pixel.x, textureSize(lit_picture, 0).y - 1 - pixel.y)), 1.0);
}
