// SPDX-License-Identifier: Apache-2.0
// A pixel of the picture between passes 2 and 3: red, green, blue and 1 as four half floats, displayed
// (sRGB) values from 0 to 1.
#ifndef FANLIGHT_SHADERS_LIT_PICTURE_H
#define FANLIGHT_SHADERS_LIT_PICTURE_H

#ifndef FANLIGHT_WEB
vec3 unpacked(uvec2 halves) {
  return vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x);
}
uvec2 packed(vec3 colour) {
  return uvec2(packHalf2x16(colour.rg), packHalf2x16(vec2(colour.b, 1.0)));
}
#endif

// Luma of a displayed colour (Rec. 709).
float brightness(vec3 colour) {
  return dot(colour, vec3(0.2126, 0.7152, 0.0722));
}

#endif
