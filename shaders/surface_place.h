// SPDX-License-Identifier: Apache-2.0
// Places a surface within the window of samples that found its edge: the second of two scales, or the ridge.
// The includer has included edge_detector.h and sample_batch.h, and declared kPlace.
//
// A wide window finds an edge among speckle, and misplaces it by the noise of many samples; before a thin
// bright surface it has its maximum as soon as the surface enters. A narrow window places the edge that is
// known to be there.
#ifndef FANLIGHT_SHADERS_SURFACE_PLACE_H
#define FANLIGHT_SHADERS_SURFACE_PLACE_H

// Samples in a half of the narrow window.
const int kNarrow = kWindow >= 4 ? 2 : 1;
// A later peak takes the place of an earlier one where this share of it is higher: the front edge of a
// surface goes before what is a little brighter behind it.
const float kFrontShare = 0.4;
// Heights that differ by less are alike: of a plateau the first sample is its peak, whatever the rounding.
const float kAlike = 1.001;

// The newest samples, oldest first, and the heights of the two newest steps; -1: unknown. Without a narrow
// window (the ridge) a height is the newest sample itself.
struct NarrowWindow {
  float recent[2 * kNarrow];
  float before;  // height one sample before `last`
  float last;
};

// The height with this sample as the newest. `number`: of the sample in the wide window, from 0.
float height_with(inout NarrowWindow narrow, float value, int number) {
  if (kPlace == FANLIGHT_PLACE_RIDGE) return number < kWindow ? value : -1.0;
  [[unroll]] for (int each = 0; each + 1 < 2 * kNarrow; ++each) narrow.recent[each] = narrow.recent[each + 1];
  narrow.recent[2 * kNarrow - 1] = value;
  float sum = 0.0;
  [[unroll]] for (int each = 0; each < kNarrow; ++each) {
    sum += narrow.recent[kNarrow + each] - narrow.recent[each];
  }
  float height = kSign == 0 ? abs(sum) : float(kSign) * sum;
  return number >= 2 * kNarrow - 1 && number < kWindow ? height : -1.0;
}

// Samples from a height back to where it lies.
float behind_newest() {
  return kPlace == FANLIGHT_PLACE_RIDGE ? 0.0 : float(kNarrow) - 0.5;
}

// The position of the surface whose edge lies at `position`; both in samples from the ray's start. Loops that
// are not unrolled: an array of the window would be code of the same size again.
float placed(Ray ray, float position) {
  // The peak's offset is above -0.5 and at most 0.5: its window's newest sample, as in middle_of_window().
  float oldest = ceil(position + float(kHalf) - 1.0) - float(kWindow - 1);
  float share = kPlace == FANLIGHT_PLACE_RIDGE ? 1.0 / kAlike : kFrontShare;
  float found = -1.0;
  float highest = 1e-6;  // height of the peak at `found`
  NarrowWindow narrow;
  [[unroll]] for (int each = 0; each < 2 * kNarrow; ++each) narrow.recent[each] = 0.0;
  narrow.before = narrow.last = -1.0;
  // One sample more than the window, of no height: the last height may be a peak.
  [[dont_unroll]] for (int first = 0; first <= kWindow; first += kBatch) {
    float batch[kBatch];
    samples_from(ray, oldest + float(first), batch);
    [[unroll]] for (int slot = 0; slot < kBatch; ++slot) {
      float height = height_with(narrow, max(batch[slot], 0.0), first + slot);
      float reach = kAlike * narrow.last;
      bool peak = reach >= narrow.before && reach >= height && share * narrow.last > highest;
      float at = float(first + slot - 1) - behind_newest() + peak_offset(narrow.before, narrow.last, height);
      found = peak ? at : found;
      highest = peak ? narrow.last : highest;
      narrow.before = narrow.last;
      narrow.last = height;
    }
  }
  return found < 0.0 ? position : oldest + found;
}

#endif
