// SPDX-License-Identifier: Apache-2.0
// Pass 0, guided filter, step 2: applies the mean of the lines of all windows that contain the pixel
// (renderer/ALGORITHM.md, pass 0).
//
// Reads: frames, words of four pixels (frame_words.h), and coefficients (guided_fit.comp).
// Writes: filtered_frames, the same shape as frames, rounded to the nearest grey level.
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
layout(binding = FANLIGHT_BINDING_COEFFICIENTS, scalar) readonly buffer Coefficients {
  uvec4 coefficients[];
};
FANLIGHT_WORDS_TO_WRITE(FANLIGHT_BINDING_FILTERED_FRAMES, FilteredFramesWords, filtered_frames);

// Grey level 0 was not scanned: such pixels stay as they are.
layout(constant_id = 1) const bool kMasked = false;

struct Sums {
  uvec4 first;   // of a, in 1/65535
  uvec4 second;  // of b, in 255/65535 of a grey level
};

Sums entry(uint word) {
  uvec4 lines = coefficients[word - word_at(0, 0, int(prepare.first_kept))];
  return Sums(lines & 0xFFFFu, lines >> 16);
}

void put(uint word, Sums sums, uvec4 numbers) {
  vec4 scale = 1.0 / (65535.0 * vec4(numbers));
  uvec4 pixels = pixels_of(fetched(frames, int(word)));
  vec4 grey = scale * vec4(sums.first) * vec4(pixels) + 255.0 * scale * vec4(sums.second);
  uvec4 rounded = uvec4(min(grey + 0.5, 255.0));
  store(filtered_frames, int(word), word_of(kMasked ? kept_scanned(rounded, pixels) : rounded));
}

#include "sliding_window.h"

void main() {
  slide_window();
}
