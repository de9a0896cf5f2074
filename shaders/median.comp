// SPDX-License-Identifier: Apache-2.0
// Pass 0, median filter: the median over a window of kSide x kSide pixels and kAcross frames, to reduce
// speckle (renderer/ALGORITHM.md, pass 0). The window is clipped to the volume; of an even number of pixels
// it is the lower median. Found by bisection over the grey levels, which needs no sorting.
//
// Reads: frames, words of four pixels (frame_words.h).
// Writes: filtered_frames, the same shape.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "bindings.h"
#include "buffer_access.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants {
  PrepareConstants prepare;
};
#include "frame_words.h"

layout(local_size_x = 64) in;  // x: words of a row; y: rows; z: frames

// The window: kSide x kSide pixels, at most 7 x 7, of kAcross frames.
layout(constant_id = 0) const int kSide = 5;
layout(constant_id = 1) const int kAcross = 1;
// Grey level 0 was not scanned: such pixels stay as they are, and do not count in the windows of others.
layout(constant_id = 2) const bool kMasked = false;

FANLIGHT_WORDS_TO_READ(FANLIGHT_BINDING_FRAMES, FramesWords, frames);
FANLIGHT_WORDS_TO_WRITE(FANLIGHT_BINDING_FILTERED_FRAMES, FilteredFramesWords, filtered_frames);

const int kWindow = kSide * kSide * kAcross;

// The value of a pixel outside the volume, or not scanned: brighter than every grey level.
const int kAbsent = 256;

int grey_at(ivec3 at) {
  ivec3 size = ivec3(prepare.columns, prepare.rows, prepare.frames);
  bool inside = all(greaterThanEqual(at, ivec3(0))) && all(lessThan(at, size));
  ivec3 clamped = clamp(at, ivec3(0), size - 1);
  uint word = fetched(frames, int(word_at(clamped.x / 4, clamped.y, clamped.z)));
  int grey = int(word >> (8 * (clamped.x % 4)) & 0xFFu);
  return inside && !(kMasked && grey == 0) ? grey : kAbsent;
}

int median_at(ivec3 at) {
  int window[kWindow];
  int present = 0;
  for (int index = 0; index < kWindow; ++index) {
    ivec3 offset = ivec3(index % kSide, index / kSide % kSide, index / (kSide * kSide)) -
                   ivec3(kSide / 2, kSide / 2, kAcross / 2);
    window[index] = grey_at(at + offset);
    present += window[index] < kAbsent ? 1 : 0;
  }
  // The smallest grey level that at least half of the pixels, rounded up, do not exceed.
  int low = 0;
  int high = 255;
  for (int bit = 0; bit < 8; ++bit) {
    int middle = (low + high) / 2;
    int below = 0;
    for (int index = 0; index < kWindow; ++index) below += window[index] <= middle ? 1 : 0;
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
  for (int pixel = 0; pixel < 4; ++pixel)
    medians[pixel] = uint(median_at(ivec3(4 * word + pixel, row, frame)));
  uint index = word_at(word, row, frame);
  if (kMasked) medians = kept_scanned(medians, pixels_of(fetched(frames, int(index))));
  store(filtered_frames, int(index), word_of(medians));
}
