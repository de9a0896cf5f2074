// Pass 0: the median over the window, the lower one where there are two, found by halving the range of grey levels.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants { PrepareConstants prepare; };
#include "frame_words.h"

layout(local_size_x = 64) in;  // neighbouring words; y: the row, z: the frame

// Pixels of the window: kSide x kSide in the frame, at most 7, and kAcross frames.
layout(constant_id = 0) const int kSide = 5;
layout(constant_id = 1) const int kAcross = 1;

layout(binding = FANLIGHT_BINDING_FRAMES) uniform usamplerBuffer frames;
layout(binding = FANLIGHT_BINDING_PREPARED, r32ui) writeonly uniform uimageBuffer prepared;

const int kWindow = kSide * kSide * kAcross;

// What is not there counts as brighter than everything.
const int kAbsent = 256;

int grey_at(ivec3 at) {
  ivec3 size = ivec3(prepare.columns, prepare.rows, prepare.frames);
  bool inside = all(greaterThanEqual(at, ivec3(0))) && all(lessThan(at, size));
  ivec3 clamped = clamp(at, ivec3(0), size - 1);
  uint word = texelFetch(frames, int(word_at(clamped.x / 4, clamped.y, clamped.z))).x;
  return inside ? int(word >> (8 * (clamped.x % 4)) & 0xFFu) : kAbsent;
}

int median_at(ivec3 at) {
  int window[kWindow];
  int present = 0;
  for (int each = 0; each < kWindow; ++each) {
    ivec3 away = ivec3(each % kSide, each / kSide % kSide, each / (kSide * kSide)) - ivec3(kSide / 2, kSide / 2, kAcross / 2);
    window[each] = grey_at(at + away);
    present += window[each] < kAbsent ? 1 : 0;
  }
  // The smallest grey level that at least half of them, rounded up, do not exceed.
  int low = 0;
  int high = 255;
  for (int halving = 0; halving < 8; ++halving) {
    int middle = (low + high) / 2;
    int below = 0;
    for (int each = 0; each < kWindow; ++each) below += window[each] <= middle ? 1 : 0;
    bool enough = 2 * below >= present;
    high = enough ? middle : high;
    low = enough ? low : min(middle + 1, 255);
  }
  return high;
}

void main() {
  int word = int(gl_GlobalInvocationID.x);
  if (word >= words_in_row()) return;
  int row = int(gl_WorkGroupID.y);
  int frame = int(prepare.first_frame + gl_WorkGroupID.z);
  uvec4 medians = uvec4(0u);
  for (int pixel = 0; pixel < 4; ++pixel) medians[pixel] = uint(median_at(ivec3(4 * word + pixel, row, frame)));
  imageStore(prepared, int(word_at(word, row, frame)), uvec4(word_of(medians)));
}
