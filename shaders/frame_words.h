// SPDX-License-Identifier: Apache-2.0
// Words of the buffers of pass 0: four neighbouring pixels of a row, the first in the lowest byte. Rows are
// padded to whole words with zeros. Order: frame by ascending angle, row, word. The includer has declared
// the push constants as `prepare`.
#ifndef FANLIGHT_SHADERS_FRAME_WORDS_H
#define FANLIGHT_SHADERS_FRAME_WORDS_H

int words_in_row() {
  return int(prepare.columns + 3u) / 4;
}

// Index in the buffer.
uint word_at(int word, int row, int frame) {
  return (uint(frame) * prepare.rows + uint(row)) * uint(words_in_row()) + uint(word);
}

uvec4 pixels_of(uint word) {
  return uvec4(word, word >> 8, word >> 16, word >> 24) & 0xFFu;
}
uint word_of(uvec4 pixels) {
  return pixels.x | pixels.y << 8 | pixels.z << 16 | pixels.w << 24;
}

// 1 for each pixel that was scanned, where grey level 0 was not.
uvec4 scanned_of(uvec4 pixels) {
  return min(pixels, uvec4(1u));
}
// A filter's result, which stays "not scanned" or an echo as the pixel was.
uvec4 kept_scanned(uvec4 filtered, uvec4 pixels) {
  return max(filtered, uvec4(1u)) * scanned_of(pixels);
}

// The columns of a word's pixels.
ivec4 columns_of(int word) {
  return 4 * word + ivec4(0, 1, 2, 3);
}

#endif
