// SPDX-License-Identifier: Apache-2.0
// The picture between passes 2 and 3 as a texture.
#ifndef FANLIGHT_SHADERS_WEB_LIT_TEXTURE_H
#define FANLIGHT_SHADERS_WEB_LIT_TEXTURE_H
#include "light_parameters.h"
#include "lit_picture.h"

uniform highp sampler2D lit_picture;

vec3 lit_at(ivec2 pixel) {
  return texelFetch(lit_picture, clamp(pixel, ivec2(0), textureSize(lit_picture, 0) - 1), 0).rgb;
}

#endif
