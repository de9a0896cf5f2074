// SPDX-License-Identifier: Apache-2.0
// Pass 3, one step of the diffusion, as diffuse.comp.
#include "web/lit_texture.h"

#include "finish_colour.h"

out vec4 colour;

void main() {
  colour = vec4(diffused_colour(ivec2(gl_FragCoord.xy)), 1.0);
}
