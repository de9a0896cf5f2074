// SPDX-License-Identifier: Apache-2.0
// The edge detector of pass 1: finds the first surface along one ray. The includer has declared the
// parameters as `rays`, and the specialisation constants kWindow, kPlace and kSign (cast.comp).
//
// The detector compares the means of the two halves of a window of kWindow samples, the step detector of
// renderer/ALGORITHM.md, pass 1. It compares sums instead of means: the threshold is multiplied by kHalf.
// The difference of the sums is updated by each sample, so that its cost does not depend on the window.
//
// Heights are differences of sums of grey levels (0 to 1 each). Positions are in samples from the ray's
// start, and may lie between samples.
#ifndef FANLIGHT_SHADERS_EDGE_DETECTOR_H
#define FANLIGHT_SHADERS_EDGE_DETECTOR_H

const int kHalf = kWindow / 2;
// Samples of a batch (sample_batch.h): read before the next test whether the ray is complete or may skip. At
// most half a window.
const int kBatch = (kWindow + 3) / 4;

// The height of the previous step where there is none, because the window is not full. It is below every
// threshold, and so low that the interpolation of first_crossing() has no effect.
const float kNoHeight = -1e9;

// An edge above the threshold whose steepest position is still searched, or the last one.
struct PendingEdge {
  bool pending;
  float peak;         // greatest height so far
  float index;        // its newest sample
  float before;       // height one sample before the peak; negative: unknown
  float after;        // height one sample after the peak; negative: unknown
  float last_height;  // of the previous step, kNoHeight where its window was not full
};

const PendingEdge kNoEdge = PendingEdge(false, 0.0, 0.0, -1.0, -1.0, kNoHeight);

struct EdgeDetector {
  float level;            // threshold of a height
  float window[kWindow];  // previous samples, oldest first, up to the beginning of the present batch
  float difference;       // sum of the newest half of the window - sum of the oldest half
  int scanned_samples;    // without a gap: the border of the fan is not an edge of tissue
  PendingEdge edge;
  PendingEdge layer;  // with FANLIGHT_KEEP_LAYERS: the same of either sign
};

// A detector before its first sample. An output, not a return value: glslang accepts no initialiser with an
// array whose size is a specialisation constant.
void start(out EdgeDetector detector) {
  detector.level = rays.threshold * float(kHalf);
  [[unroll]] for (int slot = 0; slot < kWindow; ++slot) detector.window[slot] = 0.0;
  detector.difference = 0.0;
  detector.scanned_samples = 0;
  detector.edge = kNoEdge;
  detector.layer = kNoEdge;
}

bool is_pending(EdgeDetector detector) {
  return detector.edge.pending || (kKeep == FANLIGHT_KEEP_LAYERS && detector.layer.pending);
}

// Empties the window where `restarts`: samples were skipped. Called only without a pending edge.
void restart_where(inout EdgeDetector detector, bool restarts) {
  [[unroll]] for (int slot = 0; slot < kWindow; ++slot) {
    detector.window[slot] = restarts ? 0.0 : detector.window[slot];
  }
  detector.difference = restarts ? 0.0 : detector.difference;
  detector.scanned_samples = restarts ? 0 : detector.scanned_samples;
  detector.edge.last_height = restarts ? kNoHeight : detector.edge.last_height;
  detector.layer.last_height = restarts ? kNoHeight : detector.layer.last_height;
}

// The position between the halves of the window whose newest sample is given.
float middle_of_window(float newest) {
  return newest - (float(kHalf) - 0.5);
}

// Offset of the maximum from the middle of three neighbouring heights, in samples: the vertex of the parabola
// through them, where both neighbours are known (not negative), else 0.
float peak_offset(float before, float peak, float after) {
  float curvature = before - 2.0 * peak + after;
  bool known = before >= 0.0 && after >= 0.0 && curvature < 0.0;
  return known ? clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
}

float position_of(PendingEdge edge) {
  return middle_of_window(edge.index) + peak_offset(edge.before, edge.peak, edge.after);
}

// Follows an edge to its steepest position. Returns the position where the edge ends with this step, else -1.
// An edge ends where its height falls to half of its peak or to the threshold.
float follow_edge(inout PendingEdge edge, float level, float height, bool full, float index) {
  bool crossed = full && height > level && edge.last_height <= level;
  edge.after = index == edge.index + 1.0 && full ? height : edge.after;
  bool ended = edge.pending && (!full || height <= max(level, 0.5 * edge.peak));
  float found = ended ? position_of(edge) : -1.0;
  crossed = crossed && !edge.pending;
  edge.pending = edge.pending && !ended;
  bool higher = crossed || (edge.pending && height > edge.peak);
  edge.peak = higher ? height : edge.peak;
  edge.index = higher ? index : edge.index;
  edge.before = higher ? edge.last_height : edge.before;
  edge.after = higher ? -1.0 : edge.after;
  edge.pending = edge.pending || crossed;
  edge.last_height = full ? height : kNoHeight;
  return found;
}

// The position where the threshold is crossed with this step: interpolated between it and the previous one.
// Else -1.
float first_crossing(inout PendingEdge edge, float level, float height, bool full, float index) {
  bool crossed = full && height > level && edge.last_height <= level;
  float beyond = min((height - level) / (height - edge.last_height), 1.0);
  edge.last_height = full ? height : kNoHeight;
  return crossed ? middle_of_window(index) - beyond : -1.0;
}

// Edges that end with one step: positions, or -1.
struct EdgesFound {
  float surface;
  float layer;         // of either sign, with FANLIGHT_KEEP_LAYERS
  float layer_height;  // its peak
};

// Advances the detector by one sample. `slot` is the sample's number in the present batch, at most kHalf;
// `value` is 0 where it was not `scanned`.
EdgesFound advance(inout EdgeDetector detector, int slot, float value, bool scanned, float index) {
  detector.scanned_samples = scanned ? detector.scanned_samples + 1 : 0;
  // One sample moves from the newest half to the oldest half, and one leaves the window.
  detector.difference += value - 2.0 * detector.window[slot + kHalf] + detector.window[slot];
  float height = kSign == 0 ? abs(detector.difference) : float(kSign) * detector.difference;
  bool full = detector.scanned_samples >= kWindow;
  EdgesFound found = EdgesFound(-1.0, -1.0, 0.0);
  if (kPlace == FANLIGHT_PLACE_FIRST_CROSSING) {
    found.surface = first_crossing(detector.edge, detector.level, height, full, index);
  } else {
    found.surface = follow_edge(detector.edge, detector.level, height, full, index);
  }
  if (kKeep == FANLIGHT_KEEP_LAYERS) {
    found.layer = follow_edge(detector.layer, detector.level, abs(detector.difference), full, index);
    found.layer_height = detector.layer.peak;
  }
  return found;
}

// Moves a batch of samples, which were all given to advance(), into the window.
void shift_window(inout EdgeDetector detector, float batch[kBatch]) {
  [[unroll]] for (int slot = 0; slot < kWindow - kBatch; ++slot) {
    detector.window[slot] = detector.window[slot + kBatch];
  }
  [[unroll]] for (int slot = 0; slot < kBatch; ++slot) {
    detector.window[kWindow - kBatch + slot] = batch[slot];
  }
}

// The position of an edge that is still pending where the ray ends, else -1.
float last_edge(EdgeDetector detector) {
  return kPlace != FANLIGHT_PLACE_FIRST_CROSSING && detector.edge.pending ? position_of(detector.edge) : -1.0;
}

// The same of a layer.
float last_layer(EdgeDetector detector) {
  return detector.layer.pending ? position_of(detector.layer) : -1.0;
}

#endif
