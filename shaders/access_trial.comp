// SPDX-License-Identifier: Apache-2.0
// Reads a buffer as the inner loop of pass 1 does, and nothing else: measures which kind of buffer this
// driver reads faster (renderer/vulkan/access_trial.hpp).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "buffer_access.h"
#include "whole_number.h"

layout(local_size_x = 64) in;

const int kSteps = 48;
const float kRow = 131.0;  // words from one row to the next

FANLIGHT_WORDS_TO_READ(0, TrialWords, words);
layout(binding = 1, scalar) writeonly buffer Sums {
  uint sums[];
};

// Like a sample: four words around a position, interpolated.
float sample_near(vec2 at) {
  vec2 first = floor(at);
  int here = whole(first.y * kRow + first.x);
  uvec4 near = uvec4(fetched(words, here), fetched(words, here + 1), fetched(words, here + 131),
                     fetched(words, here + 132));
  vec4 levels = vec4(ivec4(near & 0xFFu));
  vec2 part = at - first;
  vec2 row = mix(levels.xz, levels.yw, part.x);
  return mix(row.x, row.y, part.y);
}

void main() {
  vec2 start = vec2(float(int(gl_LocalInvocationID.x)) * 0.7, float(int(gl_WorkGroupID.x)) * 0.9);
  // What a ray keeps: it has to survive each read.
  vec4 kept[4] = vec4[](vec4(0.0), vec4(1.0), vec4(2.0), vec4(3.0));
  [[dont_unroll]] for (int number = 0; number < kSteps; number += 2) {
    vec2 at = start + float(number) * vec2(0.31, 0.77);
    float one = sample_near(at);
    float two = sample_near(at + vec2(0.31, 0.77));
    [[unroll]] for (int each = 0; each < 4; ++each) {
      kept[each] = max(kept[each].yzwx * 0.5 + one, vec4(two) - kept[each]);
    }
  }
  vec4 sum = kept[0] + kept[1] + kept[2] + kept[3];
  sums[gl_GlobalInvocationID.x] = floatBitsToUint(sum.x + sum.y + sum.z + sum.w);
}
