// SPDX-License-Identifier: Apache-2.0
// How certain the surface of a pixel is, 0 to 1, in the alpha of volume_colour: 0 without a surface, else 1
// to 255.
#ifndef FANLIGHT_SHADERS_CERTAINTY_H
#define FANLIGHT_SHADERS_CERTAINTY_H

const float kCertaintySteps = 254.0;

// The alpha of a pixel with a surface, as a float from 0 to 1.
float alpha_of(float certainty) {
  return (1.0 + kCertaintySteps * certainty) / 255.0;
}

bool has_surface(uint colour) {
  return colour >> 24 > 0u;
}

// 0 without a surface.
float certainty_of(uint colour) {
  return max(float(colour >> 24) - 1.0, 0.0) / kCertaintySteps;
}

#endif
