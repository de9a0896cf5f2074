// Pass 0: the mean over the window.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
#include "frame_words.h"

layout(binding = FANLIGHT_BINDING_FRAMES) uniform usamplerBuffer frames;
layout(binding = FANLIGHT_BINDING_PREPARED, r32ui) writeonly uniform uimageBuffer prepared;

struct Sums {
  uvec4 first;   // of grey levels
  uvec4 second;  // not needed
};

Sums entry(uint word) { return Sums(pixels_of(texelFetch(frames, int(word)).x), uvec4(0u)); }

// Rounded to the nearest grey level.
void put(uint word, Sums sums, uvec4 numbers) {
  imageStore(prepared, int(word), uvec4(word_of((2u * sums.first + numbers) / (2u * numbers))));
}

#include "column_walk.h"

void main() { walk(); }
