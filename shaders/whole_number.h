// SPDX-License-Identifier: Apache-2.0
// Converts floats that hold whole numbers to integers. GLSL's int() takes any float: lavapipe of Mesa 25
// clamps it lane by lane, in 60 instructions for each eight lanes: most of why pass 1 took 1.6 times as long.
#ifndef FANLIGHT_SHADERS_WHOLE_NUMBER_H
#define FANLIGHT_SHADERS_WHOLE_NUMBER_H

// `number` is whole, 0 to 2^23 - 1. After the sum its bits are the mantissa.
int whole(float number) {
  return floatBitsToInt(number + 8388608.0) - 0x4B000000;
}

#endif
