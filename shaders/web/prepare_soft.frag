// SPDX-License-Identifier: Apache-2.0
// The same for soft light, for each 2 x 2 pixels: which of the four stands for all, sky, known.
#include "web/received_surface.h"

#include "soft_surface.h"

out vec4 prepared;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  Place place = place_at(at);
  ivec2 which = place.pixel - 2 * at;
  prepared = vec4(float(which.x + 2 * which.y), place.sky, place.known, 0.0);
}
