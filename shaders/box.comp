// Pass 0: the mean over the window.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_8bit_storage : require
#include "bindings.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
layout(binding = FANLIGHT_BINDING_FRAMES, scalar) readonly buffer Frames { uint8_t frames[]; };
layout(binding = FANLIGHT_BINDING_PREPARED, scalar) writeonly buffer Prepared { uint8_t prepared[]; };

uvec2 entry(uint voxel) { return uvec2(uint(frames[voxel]), 0u); }

// Rounded to the nearest grey level.
void put(uint voxel, uvec2 sum, uint number) { prepared[voxel] = uint8_t((2u * sum.x + number) / (2u * number)); }

#include "column_walk.h"

void main() { walk(); }
