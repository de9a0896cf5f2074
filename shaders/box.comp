// Pass 0: the mean over the window.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
#include "frame_words.h"

layout(binding = FANLIGHT_BINDING_FRAMES, scalar) readonly buffer Frames { uint frames[]; };
layout(binding = FANLIGHT_BINDING_PREPARED, scalar) writeonly buffer Prepared { uint prepared[]; };

struct Sums {
  uvec4 first;   // of grey levels
  uvec4 second;  // not needed
};

Sums entry(uint word) { return Sums(pixels_of(frames[word]), uvec4(0u)); }

// Rounded to the nearest grey level.
void put(uint word, Sums sums, uvec4 numbers) {
  prepared[word] = word_of((2u * sums.first + numbers) / (2u * numbers));
}

#include "column_walk.h"

void main() { walk(); }
