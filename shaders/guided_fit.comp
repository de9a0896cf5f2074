// SPDX-License-Identifier: Apache-2.0
// Pass 0, guided filter, step 1: fits the line a I + b to each window (renderer/ALGORITHM.md, pass 0). The
// line keeps edges and flattens speckle. Its variance is (noise * mean)^2 where it multiplies, and levels^2
// where log compression has made it a sum. So a = 1 - their sum / variance, at least 0 (Lee 1980), and b =
// (1 - a) mean.
//
// Reads: frames, words of four pixels (frame_words.h).
// Writes: coefficients, uvec4 for each word from frame first_kept on: a (0 to 1) and b (in 255 grey levels)
//   of each pixel as two unorm16; 0 in the padding.
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
layout(binding = FANLIGHT_BINDING_COEFFICIENTS, scalar) writeonly buffer Coefficients {
  uvec4 coefficients[];
};

// Grey level 0 was not scanned: such pixels stay as they are, and do not count in the windows of others.
layout(constant_id = 1) const bool kMasked = false;

struct Sums {
  uvec4 first;   // of grey levels; if kMasked, in the upper half of scanned pixels
  uvec4 second;  // of their squares
};

// The grey levels of at most 147 pixels fill 16 bits.
const int kNumberShift = 16;

Sums entry(uint word) {
  uvec4 grey = pixels_of(fetched(frames, int(word)));
  return Sums(kMasked ? grey | scanned_of(grey) << kNumberShift : grey, grey * grey);
}

// A volume is filtered some frames at a time, and only the coefficients of these frames are in the buffer.
void put(uint word, Sums sums, uvec4 numbers) {
  if (kMasked) {
    numbers = max(sums.first >> kNumberShift, uvec4(1u));
    sums.first &= (1u << kNumberShift) - 1u;
  }
  uint kept = word - word_at(0, 0, int(prepare.first_kept));
  ivec4 columns = columns_of(int(word % uint(words_in_row())));
  vec4 number = vec4(numbers);
  vec4 mean = vec4(sums.first) / number;
  // In whole numbers: with at most 147 pixels of at most 255 both products are below 2^32.
  vec4 variance = vec4(sums.second * numbers - sums.first * sums.first) / (number * number);
  vec4 multiplied = prepare.noise * mean;
  vec4 speckle = multiplied * multiplied + prepare.levels * prepare.levels;
  uvec4 packed = uvec4(0u);
  for (int pixel = 0; pixel < 4; ++pixel) {
    float speckle_fraction = variance[pixel] > 0.0 ? speckle[pixel] / variance[pixel] : 1.0;
    float a = max(1.0 - speckle_fraction, 0.0);
    uint line = packUnorm2x16(vec2(a, (1.0 - a) * mean[pixel] / 255.0));
    packed[pixel] = columns[pixel] < int(prepare.columns) ? line : 0u;
  }
  coefficients[kept] = packed;
}

#include "sliding_window.h"

void main() {
  slide_window();
}
