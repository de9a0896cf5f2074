// SPDX-License-Identifier: Apache-2.0
// Sums over the window around each pixel of a frame, for the box and guided filters of pass 0. One invocation
// moves down a strip of four columns (one word) and kStrip rows of one frame. It keeps the sums of the
// window's rows, so that four pixels cost one new row of their windows, whatever the height of the window.
// Sums are whole numbers: subtracting what was added is exact.
//
// The includer has declared the push constants as `prepare`, and
//   struct Sums { uvec4 first; uvec4 second; }: two values for each of the four pixels of a word.
//   Sums entry(uint word): the values of a word; 0 in the padding.
//   void put(uint word, Sums sums, uvec4 numbers): writes a word's result. `sums`: over the windows of its
//     pixels. `numbers`: pixels in these windows.
#ifndef FANLIGHT_SHADERS_SLIDING_WINDOW_H
#define FANLIGHT_SHADERS_SLIDING_WINDOW_H

layout(local_size_x = 64) in;  // x: words of a row; y: strips of rows; z: frames

// Side of the window in a frame, pixels, odd and at most 7. A constant, so that the sums of the rows stay in
// registers.
layout(constant_id = 0) const int kSide = 5;

const int kRadius = kSide / 2;
const int kStrip = 64;

// Sums over the 2 kRadius + 1 neighbours in a row of each pixel of `here`, the middle of three words.
uvec4 row_windows(uvec4 before, uvec4 here, uvec4 after) {
  uint row[12] = uint[](before.x, before.y, before.z, before.w, here.x, here.y, here.z, here.w, after.x,
                        after.y, after.z, after.w);
  uvec4 sums = uvec4(0u);
  [[unroll]] for (int pixel = 0; pixel < 4; ++pixel) {
    [[unroll]] for (int away = -kRadius; away <= kRadius; ++away) sums[pixel] += row[4 + pixel + away];
  }
  return sums;
}

// The values of a word of a row, 0 outside the frame.
Sums entry_in_row(int word, int row, int frame) {
  bool inside = word >= 0 && word < words_in_row();
  Sums found = entry(word_at(clamp(word, 0, words_in_row() - 1), row, frame));
  return Sums(inside ? found.first : uvec4(0u), inside ? found.second : uvec4(0u));
}

// The sums of a word's windows in one row, over the frames of the window; 0 outside the frame.
Sums row_sums(int word, int row, int first_frame, int last_frame) {
  bool inside = row >= 0 && row < int(prepare.rows);
  int clamped = clamp(row, 0, int(prepare.rows) - 1);
  Sums sums = Sums(uvec4(0u), uvec4(0u));
  for (int frame = first_frame; frame <= last_frame; ++frame) {
    Sums before = entry_in_row(word - 1, clamped, frame);
    Sums here = entry_in_row(word, clamped, frame);
    Sums after = entry_in_row(word + 1, clamped, frame);
    sums.first += row_windows(before.first, here.first, after.first);
    sums.second += row_windows(before.second, here.second, after.second);
  }
  return Sums(inside ? sums.first : uvec4(0u), inside ? sums.second : uvec4(0u));
}

void slide_window() {
  int word = int(gl_GlobalInvocationID.x);
  if (word >= words_in_row()) return;
  int frame = int(prepare.first_frame + gl_WorkGroupID.z);
  int first_frame = max(frame - prepare.radius_across, 0);
  int last_frame = min(frame + prepare.radius_across, int(prepare.frames) - 1);
  int first = int(gl_WorkGroupID.y) * kStrip;
  int end = min(first + kStrip, int(prepare.rows));
  ivec4 across =
      min(columns_of(word) + kRadius, int(prepare.columns) - 1) - max(columns_of(word) - kRadius, 0) + 1;
  uvec4 in_row = uvec4(max(across, 1)) * uint(last_frame - first_frame + 1);

  // A ring buffer: the sums of row y lie in slot (y - first + kRadius) % kSide.
  Sums rows[kSide];
  Sums sums = Sums(uvec4(0u), uvec4(0u));
  [[unroll]] for (int slot = 0; slot < kSide; ++slot) {
    rows[slot] = slot < kSide - 1 ? row_sums(word, first - kRadius + slot, first_frame, last_frame)
                                  : Sums(uvec4(0u), uvec4(0u));
    sums.first += rows[slot].first;
    sums.second += rows[slot].second;
  }
  for (int start = first; start < end; start += kSide) {
    [[unroll]] for (int slot = 0; slot < kSide; ++slot) {
      int row = start + slot;
      const int newest = (slot + kSide - 1) % kSide;
      Sums entering = row_sums(word, row + kRadius, first_frame, last_frame);
      sums.first += entering.first - rows[newest].first;
      sums.second += entering.second - rows[newest].second;
      rows[newest] = entering;
      uint down = uint(min(row + kRadius, int(prepare.rows) - 1) - max(row - kRadius, 0) + 1);
      if (row < end) put(word_at(word, row, frame), sums, in_row * down);
    }
  }
}

#endif
