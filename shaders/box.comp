// SPDX-License-Identifier: Apache-2.0
// Pass 0, box filter: the mean over a window of kSide x kSide pixels and 2 radius_across + 1 frames, to
// reduce speckle (renderer/ALGORITHM.md, pass 0). The window is clipped to the volume.
//
// Reads: frames, words of four pixels (frame_words.h).
// Writes: filtered_frames, the same shape, rounded to the nearest grey level.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "bindings.h"
#include "buffer_access.h"
#include "prepare_constants.h"

layout(push_constant, scalar) uniform Constants {
  PrepareConstants prepare;
};
#include "frame_words.h"

FANLIGHT_WORDS_TO_READ(FANLIGHT_BINDING_FRAMES, FramesWords, frames);
FANLIGHT_WORDS_TO_WRITE(FANLIGHT_BINDING_FILTERED_FRAMES, FilteredFramesWords, filtered_frames);

// Grey level 0 was not scanned: such pixels stay as they are, and do not count in the windows of others.
layout(constant_id = 1) const bool kMasked = false;

struct Sums {
  uvec4 first;   // of grey levels
  uvec4 second;  // of scanned pixels, if kMasked
};

Sums entry(uint word) {
  uvec4 grey = pixels_of(fetched(frames, int(word)));
  return Sums(grey, kMasked ? scanned_of(grey) : uvec4(0u));
}

void put(uint word, Sums sums, uvec4 numbers) {
  uvec4 number = kMasked ? max(sums.second, uvec4(1u)) : numbers;
  uvec4 means = (2u * sums.first + number) / (2u * number);
  if (kMasked) means = kept_scanned(means, pixels_of(fetched(frames, int(word))));
  store(filtered_frames, int(word), word_of(means));
}

#include "sliding_window.h"

void main() {
  slide_window();
}
