// SPDX-License-Identifier: Apache-2.0
// The edge detector of pass 1: shaders/edge_detector.h for a vector of rays, whose samples have the same
// numbers. See there.
#if defined(FANLIGHT_RENDERER_RAYS_EDGE_DETECTOR) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_EDGE_DETECTOR
#undef FANLIGHT_RENDERER_RAYS_EDGE_DETECTOR
#else
#define FANLIGHT_RENDERER_RAYS_EDGE_DETECTOR
#endif

#include "renderer/rays/fan_volume-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

// The height of the previous step where there is none.
constexpr float kNoHeight = -1e9F;

// The height of a step whose halves differ by `difference`.
HWY_INLINE Floats height_of(Floats difference, int sign) {
  return sign == 0 ? hn::Abs(difference) : all(static_cast<float>(sign)) * difference;
}

// Offset of the maximum from the middle of three neighbouring heights, in samples.
HWY_INLINE Floats peak_offset(Floats before, Floats peak, Floats after) {
  const Floats curvature = before - all(2.0F) * peak + after;
  const Mask known =
      hn::And(hn::And(hn::Ge(before, zero()), hn::Ge(after, zero())), hn::Lt(curvature, zero()));
  const Floats offset = clamped(all(0.5F) * (before - after) / curvature, all(-0.5F), all(0.5F));
  return hn::IfThenElseZero(known, offset);
}

// Edges that end with one step: where `found`.
struct FoundEdges {
  Mask found;
  Floats position;
  Floats height;  // of the peak
};

// Follows the edges of one kind to their steepest positions.
class EdgeFollower {
 public:
  EdgeFollower(float level, float half_window)
      : level_(all(level)),
        to_middle_(all(half_window - 0.5F)),
        last_height_(all(kNoHeight)),
        pending_(none()),
        peak_(zero()),
        peak_index_(zero()),
        before_(all(-1.0F)),
        after_(all(-1.0F)) {}

  // Forgets the last step.
  HWY_INLINE void restart() {
    last_height_ = all(kNoHeight);
    pending_ = none();
  }

  // Edges above the threshold whose steepest position is still searched.
  Mask pending() const { return pending_; }
  // These edges, where the rays end.
  FoundEdges last() const { return {pending_, position(), peak_}; }

  // follow_edge() of edge_detector.h.
  HWY_INLINE FoundEdges follow(Floats height, Mask full, Floats index) {
    const Mask crossed = hn::AndNot(pending_, crosses(height, full));
    FoundEdges edges = {none(), zero(), zero()};
    // Most samples lie outside edges.
    if (!is_empty(hn::Or(pending_, crossed))) {
      const Mask is_next = hn::And(full, hn::Eq(index, peak_index_ + all(1.0F)));
      after_ = where(is_next, height, after_);
      const Mask falls = hn::Le(height, hn::Max(level_, all(0.5F) * peak_));
      edges.found = hn::And(pending_, hn::Or(hn::Not(full), falls));
      if (!is_empty(edges.found)) edges = {edges.found, position(), peak_};
      pending_ = hn::AndNot(edges.found, pending_);
      const Mask higher = hn::Or(crossed, hn::And(pending_, hn::Gt(height, peak_)));
      peak_ = where(higher, height, peak_);
      peak_index_ = where(higher, index, peak_index_);
      before_ = where(higher, last_height_, before_);
      after_ = where(higher, all(-1.0F), after_);
      pending_ = hn::Or(pending_, crossed);
    }
    last_height_ = where(full, height, all(kNoHeight));
    return edges;
  }

  // first_crossing() of edge_detector.h.
  HWY_INLINE FoundEdges cross(Floats height, Mask full, Floats index) {
    FoundEdges edges = {crosses(height, full), zero(), zero()};
    if (!is_empty(edges.found)) {
      const Floats beyond = hn::Min((height - level_) / (height - last_height_), all(1.0F));
      edges.position = index - to_middle_ - beyond;
    }
    last_height_ = where(full, height, all(kNoHeight));
    return edges;
  }

 private:
  HWY_INLINE Mask crosses(Floats height, Mask full) const {
    return hn::And(full, hn::And(hn::Gt(height, level_), hn::Le(last_height_, level_)));
  }
  HWY_INLINE Floats position() const {
    return peak_index_ - to_middle_ + peak_offset(before_, peak_, after_);
  }

  Floats level_;
  Floats to_middle_;  // samples from the newest one back to the middle of the window
  Floats last_height_;
  Mask pending_;
  Floats peak_;
  Floats peak_index_;
  Floats before_;
  Floats after_;
};

class EdgeDetector {
 public:
  EdgeDetector(const Method& method, float threshold)
      : window_length_(method.window),
        half_(method.window / 2),
        sign_(method.sign),
        first_crossing_(method.place == FANLIGHT_PLACE_FIRST_CROSSING),
        seeks_layers_(method.kept == FANLIGHT_KEEP_LAYERS),
        level_(threshold * static_cast<float>(half_)),
        edges_(level_, static_cast<float>(half_)),
        layers_(level_, static_cast<float>(half_)) {
    restart();
  }

  // The threshold of a height.
  float level() const { return level_; }

  // Empties the window: samples were skipped. Called only without a pending edge that matters.
  HWY_INLINE void restart() {
    for (int sample = 0; sample < window_length_; ++sample) window_[sample] = zero();
    oldest_ = 0;
    difference_ = zero();
    scanned_samples_ = zero();
    edges_.restart();
    layers_.restart();
  }

  // Advances by one sample, whose value is 0 where it was not `scanned`. `layers`: edges of either sign,
  // where the method keeps them.
  HWY_INLINE FoundEdges advance(Floats value, Mask scanned, Floats index, FoundEdges& layers) {
    scanned_samples_ = hn::IfThenElseZero(scanned, scanned_samples_ + all(1.0F));
    const int in_middle = oldest_ + half_;
    const Floats middle = window_[in_middle < window_length_ ? in_middle : in_middle - window_length_];
    // One sample moves from the newest half to the oldest half, and one leaves the window.
    difference_ = difference_ + (value - all(2.0F) * middle + window_[oldest_]);
    window_[oldest_] = value;
    oldest_ = oldest_ + 1 == window_length_ ? 0 : oldest_ + 1;
    const Mask full = hn::Ge(scanned_samples_, all(static_cast<float>(window_length_)));
    if (seeks_layers_) layers = layers_.follow(hn::Abs(difference_), full, index);
    const Floats height = height_of(difference_, sign_);
    return first_crossing_ ? edges_.cross(height, full, index) : edges_.follow(height, full, index);
  }

  const EdgeFollower& edges() const { return edges_; }
  const EdgeFollower& layers() const { return layers_; }

 private:
  int window_length_;
  int half_;
  int sign_;
  bool first_crossing_;
  bool seeks_layers_;
  float level_;
  Floats window_[kMostWindow];  // a ring
  int oldest_ = 0;              // in the ring
  Floats difference_;
  Floats scanned_samples_;
  EdgeFollower edges_;
  EdgeFollower layers_;
};

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
