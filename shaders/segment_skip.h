// SPDX-License-Identifier: Apache-2.0
// Empty space skipping along one ray, by the segment mask of its tile (empty_space.comp). The includer has
// declared the parameters as `rays`, and the specialisation constant kWindow. Samples are counted from the
// ray's start; `index` and `end` are whole numbers in floats, which a processor need not convert.
#ifndef FANLIGHT_SHADERS_SEGMENT_SKIP_H
#define FANLIGHT_SHADERS_SEGMENT_SKIP_H

// The first sample from `index` on in a segment whose bit is set; beyond the end of every ray if there is
// none.
int first_sample_in(uvec4 segment_mask, int index) {
  int segment = index >> rays.segment_shift;
  int found = 1 << 16;
  [[unroll]] for (int part = FANLIGHT_MAX_SEGMENTS / 32 - 1; part >= 0; --part) {
    int passed = segment - 32 * part;  // segments of this part before `index`
    uint remaining = passed >= 32 ? 0u : segment_mask[part] & (~0u << uint(max(passed, 0)));
    found = remaining != 0u ? 32 * part + findLSB(remaining) : found;
  }
  return max(index, found << rays.segment_shift);
}

// Consecutive samples that have to be read: from `first` to before `end`.
struct SampleRun {
  float first;
  float end;
};

// The next run of a ray that has reached `index`, and ends at `end`. It covers consecutive segments whose
// bits are set. It begins one window earlier, so that the detector's window is full in the first segment.
SampleRun next_run(uvec4 segment_mask, float index, float end) {
  int next = first_sample_in(segment_mask, whole(index));
  float run_end = min(end, float(first_sample_in(~segment_mask, next)));
  float first = next >= whole(end) ? end : float(next - kWindow);
  return SampleRun(max(first, index), run_end);
}

#endif
