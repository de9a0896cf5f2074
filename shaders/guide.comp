// Pass 0, guided filter, first half: in each window the line a I + b that keeps an edge and flattens speckle. Speckle
// multiplies, so what deviates from its mean by the share that speckle does is flat: a = 1 - (noise mean)^2 / variance
// (Lee 1980), b = (1 - a) mean.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_8bit_storage : require
#include "bindings.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(binding = FANLIGHT_BINDING_FRAMES, scalar) readonly buffer Frames { uint8_t frames[]; };
layout(binding = FANLIGHT_BINDING_COEFFICIENTS, scalar) writeonly buffer Coefficients { uint coefficients[]; };

// A volume is filtered some frames at a time: the coefficients of those alone are kept.
uint kept_at(uint voxel) { return voxel - prepare.first_kept * prepare.columns * prepare.rows; }

uvec2 entry(uint voxel) {
  uint grey = uint(frames[voxel]);
  return uvec2(grey, grey * grey);
}

void put(uint voxel, uvec2 sum, uint number) {
  float mean = float(sum.x) / float(number);
  // In whole numbers: at most 147 pixels of 255 squared keep both products below 2^32.
  float variance = float(sum.y * number - sum.x * sum.x) / float(number * number);
  float speckle = prepare.noise * mean;
  float a = variance > 0.0 ? max(1.0 - speckle * speckle / variance, 0.0) : 0.0;
  coefficients[kept_at(voxel)] = packUnorm2x16(vec2(a, (1.0 - a) * mean / 255.0));
}

#include "column_walk.h"

void main() { walk(); }
