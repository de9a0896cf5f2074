// SPDX-License-Identifier: Apache-2.0
// Places a surface within the window of samples that found its edge: the second of two scales, the ridge, or
// the level of the tissue. The includer has included edge_detector.h and sample_batch.h, and declared kPlace.
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

// In place of a position: the edge is no surface. Below the position of any sample.
const float kNotTissue = -1e9;

// Of a window with many samples every second one is read: half the time, and neighbours differ little.
const int kLevelStride = kHalf < 8 ? 1 : 2;
// Samples of a window and half a window beyond it, and of a window alone, with that stride.
const int kLevelSamples = (kWindow + kHalf + kLevelStride - 1) / kLevelStride;
const int kWindowSamples = (kWindow + kLevelStride - 1) / kLevelStride;
// Samples of which the means are compared with the level of the tissue.
const int kLevelMean = kHalf < 8 ? kHalf : 4;
// Samples whose mean distinguishes a thin bright surface from fluid, and is its peak.
const int kShortMean = (kLevelMean + 1) / 2;
// A sheet: no more samples are brighter than halfway from the fluid to the peak.
const int kMostOfASheet = kLevelMean;
// The foot of a rise: this many times as far below the tissue as rays.rise, so that it is as many decibels
// below whatever the contrast; within these shares of the way from the fluid.
const float kFoot = 2.4;
const float kLeastFoot = 0.25;
const float kMostFoot = 0.5;
// Over which the pulse and the filters of pass 0 spread the echo of a surface that is met at a right angle.
const float kOwnRiseMm = 0.5;
// A surface is certain where fluid and tissue differ by twice rays.least_contrast, or by so much more than
// that.
const float kMostUncertain = 30.0 / 255.0;
// Of a sheet without speckle the level is not nearer to the peak than of a contrast of 50 dB.
const float kMostSheetRise = 0.92;

// The samples from `first` towards the tissue. Where nothing was scanned, and outside the run, 0. Unrolled:
// an array that is indexed at run time lies in memory.
void samples_inwards(Ray ray, SampleRun run, float first, float inwards, out float values[kLevelSamples]) {
  Ray strided = ray;
  strided.spacing *= float(kLevelStride);
  float origin = first / float(kLevelStride);
  [[unroll]] for (int number = 0; number < kLevelSamples; number += kBatch) {
    float along[kBatch];
    samples_from(strided, inwards > 0.0 ? origin + float(number) : origin - float(number + kBatch - 1),
                 along);
    [[unroll]] for (int slot = 0; slot < kBatch; ++slot) {
      float index = first + inwards * float(kLevelStride * (number + slot));
      float value = inwards > 0.0 ? along[slot] : along[kBatch - 1 - slot];
      value = index >= run.first && index < run.end ? max(value, 0.0) : 0.0;
      if (number + slot < kLevelSamples) values[number + slot] = value;
    }
  }
}

// The sum of the `count` values that end with this one.
float sum_to(float values[kLevelSamples], int last, int count) {
  float sum = 0.0;
  [[unroll]] for (int each = 0; each < count; ++each) sum += values[last - each];
  return sum;
}

// +1 where the window is darker in its first half, else -1.
float direction_inwards(Ray ray, float oldest) {
  if (kSign != 0) return float(kSign);
  float difference = 0.0;
  [[dont_unroll]] for (int first = 0; first < kWindow; first += kBatch) {
    float batch[kBatch];
    samples_from(ray, oldest + float(first), batch);
    [[unroll]] for (int slot = 0; slot < kBatch; ++slot) {
      float weight = first + slot < kHalf ? -1.0 : first + slot < kWindow ? 1.0 : 0.0;
      difference += weight * max(batch[slot], 0.0);
    }
  }
  return difference >= 0.0 ? 1.0 : -1.0;
}

// The level at the front of a sheet, or between the fluid and the tissue behind an edge.
float level_of(float values[kLevelSamples], float fluid, float tissue) {
  float peak = 0.0;
  [[unroll]] for (int last = kShortMean - 1; last < kLevelSamples; ++last) {
    peak = max(peak, sum_to(values, last, kShortMean));
  }
  peak /= float(kShortMean);
  float middle = 0.5 * (fluid + peak);
  int brighter = 0;
  [[unroll]] for (int each = 0; each < kLevelSamples; ++each) brighter += values[each] > middle ? 1 : 0;
  float front = clamp(peak - rays.sheet_below, middle, mix(fluid, peak, kMostSheetRise));
  return brighter <= kMostOfASheet ? front : mix(fluid, tissue, rays.rise);
}

// Where the echo first rises past a level, and where it last rose past the foot before, in values from the
// first; -1: nowhere.
struct Rise {
  float foot;
  float level;
};

Rise rise_through(float values[kLevelSamples], float foot_level, float level) {
  Rise rise = Rise(-1.0, -1.0);
  [[unroll]] for (int next = 1; next < kLevelSamples; ++next) {
    float before = values[next - 1];
    float after = values[next];
    float step = max(after - before, 1e-6);
    float foot = float(next - 1) + clamp((foot_level - before) / step, 0.0, 1.0);
    rise.foot = rise.level < 0.0 && before < foot_level && after >= foot_level ? foot : rise.foot;
    float place = float(next - 1) + clamp((level - before) / step, 0.0, 1.0);
    rise.level = rise.level < 0.0 && before < level && after >= level ? place : rise.level;
  }
  return rise;
}

// Values from a rise to the surface behind it: a beam that meets a slanted surface reaches it with its border
// first, and its echo rises slowly. The longer the rise, the farther behind lies the surface.
float reach_behind(Rise rise, float spacing) {
  float value_mm = float(kLevelStride) * spacing;
  float long_mm = rise.foot < 0.0 ? 0.0 : (rise.level - rise.foot) * value_mm - kOwnRiseMm;
  return min(rays.reach * max(long_mm, 0.0), float(kHalf) * spacing) / value_mm;
}

// Echoes about an edge: means of kLevelMean samples but for `brightest`.
struct EdgeEchoes {
  float start;      // position of the first sample
  float inwards;    // +1 or -1: from the fluid towards the tissue
  float fluid;      // the darkest mean within the window
  float tissue;     // the brightest up to half a window beyond it
  float brightest;  // mean of kShortMean samples behind the window's middle
};

// Of the edge at `position`, with the samples from the fluid towards the tissue. `run`: the samples of the
// ray.
EdgeEchoes echoes_about(Ray ray, SampleRun run, float position, out float values[kLevelSamples]) {
  EdgeEchoes echoes;
  float oldest = ceil(position + float(kHalf) - 1.0) - float(kWindow - 1);
  echoes.inwards = direction_inwards(ray, oldest);
  echoes.start = echoes.inwards > 0.0 ? oldest : oldest + float(kWindow - 1);
  samples_inwards(ray, run, echoes.start, echoes.inwards, values);
  float fluid = 1e6;
  float tissue = 0.0;
  float brightest = 0.0;
  [[unroll]] for (int last = kWindowSamples / 2 + kShortMean - 1; last < kLevelSamples; ++last) {
    brightest = max(brightest, sum_to(values, last, kShortMean));
  }
  [[unroll]] for (int last = kLevelMean - 1; last < kLevelSamples; ++last) {
    float sum = sum_to(values, last, kLevelMean);
    tissue = max(tissue, sum);
    if (last < kWindowSamples) fluid = min(fluid, sum);
  }
  echoes.fluid = fluid / float(kLevelMean);
  echoes.tissue = tissue / float(kLevelMean);
  echoes.brightest = brightest / float(kShortMean);
  return echoes;
}

// The certainty of a surface: from 0 where tissue and fluid differ by rays.least_contrast to 1; -1 where they
// differ by less, as speckle alone does: that is no surface.
float certainty_by(EdgeEchoes echoes) {
  float beyond = echoes.tissue - echoes.fluid - rays.least_contrast;
  float certain_beyond = min(rays.least_contrast, kMostUncertain);
  float share = certain_beyond > 0.0 ? min(beyond / certain_beyond, 1.0) : 1.0;
  return beyond < 0.0 ? -1.0 : share;
}

// The position of the surface whose edge lies at `position`: where the echo, coming from the fluid, first
// rises past rays.rise of the way to the tissue's, and past rays.least_tissue. A thin bright sheet has its
// front rays.sheet_below under its peak: a mean would hold fluid on both sides of it. The surface lies behind
// that place where the echo rises slowly (reach_behind). kNotTissue where nothing behind the window's middle
// reaches rays.least_tissue, and where certainty_by() finds no surface. `run`: the samples of the ray.
float placed_by_level(Ray ray, SampleRun run, float position, out float certainty) {
  float values[kLevelSamples];
  EdgeEchoes echoes = echoes_about(ray, run, position, values);
  certainty = certainty_by(echoes);
  if (echoes.brightest < rays.least_tissue || certainty < 0.0) return kNotTissue;
  float level = max(level_of(values, echoes.fluid, echoes.tissue), rays.least_tissue);
  float foot = clamp(1.0 - kFoot * (1.0 - rays.rise), kLeastFoot, kMostFoot);
  float foot_level = min(mix(echoes.fluid, echoes.tissue, foot), level);
  Rise rise = rise_through(values, foot_level, level);
  float found = rise.level + reach_behind(rise, ray.spacing);
  return rise.level < 0.0 ? position : echoes.start + echoes.inwards * float(kLevelStride) * found;
}

// certainty_by() of the edge at `position`.
float certainty_at(Ray ray, SampleRun run, float position) {
  float values[kLevelSamples];
  return certainty_by(echoes_about(ray, run, position, values));
}

#endif
