// SPDX-License-Identifier: Apache-2.0
// Pass 2, light under the surface, as scatter.comp.
#include "bindings.h"
#include "light_parameters.h"

#include "scattered_light.h"

out vec4 place;

void main() {
  place = scattered_light(ivec2(gl_FragCoord.xy), 0u);
}
