// SPDX-License-Identifier: Apache-2.0
// The edges of a vector of rays that wait to be placed.
#if defined(FANLIGHT_RENDERER_RAYS_EDGE_QUEUE) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_EDGE_QUEUE
#undef FANLIGHT_RENDERER_RAYS_EDGE_QUEUE
#else
#define FANLIGHT_RENDERER_RAYS_EDGE_QUEUE
#endif

#include <array>
#include <bit>

#include "renderer/rays/edge_detector-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

// Edges of each ray that may be surfaces, or layers, in their order, until all rays of the vector have one:
// to place edges takes as long for one ray as for all of them.
class EdgeQueue {
 public:
  // Edges of a ray from which on they are placed first. A batch and the end of the ray add no more than
  // three.
  static constexpr int kFull = 8;
  static constexpr int kRoom = 12;

  // Written out, so that it is compiled for the instruction set.
  EdgeQueue() : waiting_(none()) {}

  void add(Mask rays, const FoundEdges& edges) {
    const LaneFloats positions = stored(edges.position);
    const LaneFloats heights = stored(edges.height);
    for (std::uint32_t bits = bits_of(rays); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      int& count = counts_[lane];
      const int place = (first_[lane] + count) % kRoom;
      positions_[place].lane[lane] = positions.lane[lane];
      heights_[place].lane[lane] = heights.lane[lane];
      full_ |= ++count >= kFull;
    }
    waiting_ = hn::Or(waiting_, rays);
  }

  // Rays that have edges.
  Mask waiting() const { return waiting_; }
  // Whether a ray has so many edges that they have to be placed.
  bool full() const { return full_; }

  // Takes the first edge of each of these rays, which have one.
  FoundEdges take(Mask rays) {
    LaneFloats positions = stored(zero());
    LaneFloats heights = positions;
    std::uint32_t empty = 0;
    for (std::uint32_t bits = bits_of(rays); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      positions.lane[lane] = positions_[first_[lane]].lane[lane];
      heights.lane[lane] = heights_[first_[lane]].lane[lane];
      first_[lane] = (first_[lane] + 1) % kRoom;
      if (--counts_[lane] == 0) empty |= 1U << static_cast<std::uint32_t>(lane);
    }
    full_ = false;
    drop(empty);
    return {rays, loaded(positions), loaded(heights)};
  }

  // Forgets the edges of these rays.
  void clear(Mask rays) {
    const std::uint32_t bits = bits_of(rays);
    for (int lane = 0; lane < static_cast<int>(kLanes); ++lane) {
      if ((bits >> static_cast<std::uint32_t>(lane) & 1U) != 0) counts_[lane] = 0;
    }
    full_ = false;
    drop(bits);
  }

 private:
  void drop(std::uint32_t lanes) {
    LaneFloats kept = stored(hn::IfThenElseZero(waiting_, all(1.0F)));
    for (; lanes != 0; lanes &= lanes - 1) kept.lane[std::countr_zero(lanes)] = 0.0F;
    waiting_ = hn::Gt(loaded(kept), zero());
  }

  std::array<LaneFloats, kRoom> positions_;
  std::array<LaneFloats, kRoom> heights_;
  std::array<int, kMostLanes> first_{};
  std::array<int, kMostLanes> counts_{};
  Mask waiting_;
  bool full_ = false;
};

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
