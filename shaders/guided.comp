// Pass 0, guided filter, second half: the mean of the lines of all windows that contain the pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_8bit_storage : require
#include "bindings.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(binding = FANLIGHT_BINDING_FRAMES, scalar) readonly buffer Frames { uint8_t frames[]; };
layout(binding = FANLIGHT_BINDING_COEFFICIENTS, scalar) readonly buffer Coefficients { uint coefficients[]; };
layout(binding = FANLIGHT_BINDING_PREPARED, scalar) writeonly buffer Prepared { uint8_t prepared[]; };

// A volume is filtered some frames at a time: the coefficients of those alone are kept.
uint kept_at(uint voxel) { return voxel - prepare.first_kept * prepare.columns * prepare.rows; }

uvec2 entry(uint voxel) {
  uint pair = coefficients[kept_at(voxel)];
  return uvec2(pair & 0xFFFFu, pair >> 16);
}

void put(uint voxel, uvec2 sum, uint number) {
  vec2 mean = vec2(sum) / (65535.0 * float(number));
  float grey = mean.x * float(uint(frames[voxel])) + mean.y * 255.0;
  prepared[voxel] = uint8_t(uint(min(grey + 0.5, 255.0)));
}

#include "column_walk.h"

void main() { walk(); }
