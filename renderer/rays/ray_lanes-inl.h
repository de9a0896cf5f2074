// SPDX-License-Identifier: Apache-2.0
// Intervals of rays. Included once for each instruction set, by ray_caster.cpp and by tile_search.cpp.
#if defined(FANLIGHT_RENDERER_RAYS_RAY_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_RAY_LANES
#undef FANLIGHT_RENDERER_RAYS_RAY_LANES
#else
#define FANLIGHT_RENDERER_RAYS_RAY_LANES
#endif

#include "renderer/lanes/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

using namespace lanes::HWY_NAMESPACE;

// An interval of a ray, mm of depth. last < first: empty.
struct Interval {
  Floats first;
  Floats last;
};
// Clips an interval to a + b t >= 0.
HWY_INLINE Interval cut(Interval part, Floats a, Floats b) {
  const Floats at = negative(a) / b;
  const Mask ahead = hn::Gt(b, zero());
  const Mask behind = hn::Lt(b, zero());
  const Mask outside = hn::AndNot(hn::Or(ahead, behind), hn::Lt(a, zero()));
  const Floats first = where(ahead, hn::Max(part.first, at), part.first);
  const Floats last = where(behind, hn::Min(part.last, at), part.last);
  return {where(outside, all(1.0F), first), where(outside, zero(), last)};
}

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
