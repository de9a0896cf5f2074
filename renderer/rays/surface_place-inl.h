// SPDX-License-Identifier: Apache-2.0
// Places surfaces within the windows that found their edges: shaders/surface_place.h for a vector of rays.
// See there.
#if defined(FANLIGHT_RENDERER_RAYS_SURFACE_PLACE) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_SURFACE_PLACE
#undef FANLIGHT_RENDERER_RAYS_SURFACE_PLACE
#else
#define FANLIGHT_RENDERER_RAYS_SURFACE_PLACE
#endif

#include <algorithm>

#include "renderer/rays/edge_detector-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

// Constants of surface_place.h.
constexpr float kFrontShare = 0.4F;
constexpr float kAlike = 1.001F;
constexpr float kFoot = 2.4F;
constexpr float kLeastFoot = 0.25F;
constexpr float kMostFoot = 0.5F;
constexpr float kOwnRiseMm = 0.5F;
constexpr float kMostUncertain = 30.0F / 255.0F;
constexpr float kMostSheetRise = 0.92F;

// Those that follow from the window.
struct PlaceSizes {
  explicit PlaceSizes(int window)
      : narrow(window >= 4 ? 2 : 1),
        stride(window / 2 < 8 ? 1 : 2),
        samples((window + window / 2 + stride - 1) / stride),
        window_samples((window + stride - 1) / stride),
        mean(window / 2 < 8 ? window / 2 : 4),
        short_mean((mean + 1) / 2) {}
  int narrow;
  int stride;
  int samples;
  int window_samples;
  int mean;
  int short_mean;
};
// With strides of 1 and 2.
constexpr int kMostLevelSamples = (kMostWindow + kMostWindow / 2 + 1) / 2;
static_assert(kMostLevelSamples >= 14 + 7);

// Where a surface lies: of the lanes that were asked for.
struct Places {
  Mask surface;      // else the edge is no surface
  Floats position;   // in samples from the ray's start
  Floats certainty;  // 0 to 1
};

class SurfacePlacer {
 public:
  SurfacePlacer(const Method& method, const shaders::CastParameters& rays, const FanVolume& volume)
      : rays_(rays),
        volume_(volume),
        window_(method.window),
        half_(method.window / 2),
        place_(method.place),
        sign_(method.sign),
        sizes_(method.window) {}

  // Of the edges at `position`. Rays have samples from `first` to before `end`.
  HWY_INLINE Places place(const Rays& ray, Floats first, Floats end, Floats position) const {
    if (place_ == FANLIGHT_PLACE_LEVEL) return placed_by_level(ray, first, end, position);
    Places places = {hn::Ge(zero(), zero()), position, all(1.0F)};
    if (place_ != FANLIGHT_PLACE_FIRST_CROSSING && place_ != FANLIGHT_PLACE_REFINED)
      places.position = placed(ray, position);
    if (rays_.least_contrast > 0.0F) {
      Floats values[kMostLevelSamples];
      places.certainty = certainty_by(echoes_about(ray, first, end, position, values));
      places.surface = hn::Ge(places.certainty, zero());
    }
    return places;
  }

 private:
  // The first sample of the window that found an edge.
  HWY_INLINE Floats oldest_of(Floats position) const {
    return hn::Ceil(position + all(static_cast<float>(half_)) - all(1.0F)) -
           all(static_cast<float>(window_ - 1));
  }

  // The newest samples, oldest first, and the heights of the two newest steps; -1: unknown.
  struct NarrowWindow {
    Floats recent[4];
    Floats before;
    Floats last;
  };
  HWY_INLINE Floats height_with(NarrowWindow& narrow, Floats value, int number) const {
    if (place_ == FANLIGHT_PLACE_RIDGE) return number < window_ ? value : all(-1.0F);
    const int length = 2 * sizes_.narrow;
    for (int each = 0; each + 1 < length; ++each) narrow.recent[each] = narrow.recent[each + 1];
    narrow.recent[length - 1] = value;
    if (number < length - 1 || number >= window_) return all(-1.0F);
    Floats sum = zero();
    for (int each = 0; each < sizes_.narrow; ++each)
      sum = sum + (narrow.recent[sizes_.narrow + each] - narrow.recent[each]);
    return height_of(sum, sign_);
  }

  // placed() of surface_place.h.
  HWY_INLINE Floats placed(const Rays& ray, Floats position) const {
    const Floats oldest = oldest_of(position);
    const bool ridge = place_ == FANLIGHT_PLACE_RIDGE;
    const Floats share = all(ridge ? 1.0F / kAlike : kFrontShare);
    const float behind_newest = ridge ? 0.0F : static_cast<float>(sizes_.narrow) - 0.5F;
    Floats found = all(-1.0F);
    Floats highest = all(1e-6F);
    NarrowWindow narrow = {{zero(), zero(), zero(), zero()}, all(-1.0F), all(-1.0F)};
    // One sample more than the window, of no height: the last height may be a peak.
    for (int first = 0; first <= window_; first += kBatch) {
      Floats batch[kBatch];
      volume_.samples_from(ray, oldest + all(static_cast<float>(first)), batch);
      for (int slot = 0; slot < kBatch; ++slot) {
        const Floats height = height_with(narrow, hn::Max(batch[slot], zero()), first + slot);
        const Floats reach = all(kAlike) * narrow.last;
        const Mask peak = hn::And(hn::And(hn::Ge(reach, narrow.before), hn::Ge(reach, height)),
                                  hn::Gt(share * narrow.last, highest));
        const Floats at_peak = all(static_cast<float>(first + slot - 1) - behind_newest) +
                               peak_offset(narrow.before, narrow.last, height);
        found = where(peak, at_peak, found);
        highest = where(peak, narrow.last, highest);
        narrow.before = narrow.last;
        narrow.last = height;
      }
    }
    return where(hn::Lt(found, zero()), position, oldest + found);
  }

  // Echoes about an edge, as in surface_place.h.
  struct EdgeEchoes {
    Floats start;
    Floats inwards;
    Floats fluid;
    Floats tissue;
    Floats brightest;
  };

  // The samples from the fluid towards the tissue; 0 where nothing was scanned, and outside the ray.
  HWY_INLINE void samples_inwards(const Rays& ray, Floats ray_first, Floats ray_end, const EdgeEchoes& echoes,
                                  Floats (&values)[kMostLevelSamples]) const {
    const auto stride = static_cast<float>(sizes_.stride);
    Rays strided = ray;
    strided.spacing = ray.spacing * all(stride);
    const Floats origin = echoes.start / all(stride);
    const Mask ahead = hn::Gt(echoes.inwards, zero());
    for (int number = 0; number < sizes_.samples; number += kBatch) {
      Floats along[kBatch];
      volume_.samples_from(strided,
                           where(ahead, origin + all(static_cast<float>(number)),
                                 origin - all(static_cast<float>(number + kBatch - 1))),
                           along);
      for (int slot = 0; slot < kBatch && number + slot < sizes_.samples; ++slot) {
        const Floats index = echoes.start + echoes.inwards * all(stride * static_cast<float>(number + slot));
        const Floats value = where(ahead, along[slot], along[kBatch - 1 - slot]);
        const Mask in_ray = hn::And(hn::Ge(index, ray_first), hn::Lt(index, ray_end));
        values[number + slot] = hn::IfThenElseZero(in_ray, hn::Max(value, zero()));
      }
    }
  }

  // The sum of the `count` values that end with this one.
  HWY_INLINE static Floats sum_to(const Floats* values, int last, int count) {
    Floats sum = zero();
    for (int each = 0; each < count; ++each) sum = sum + values[last - each];
    return sum;
  }

  // +1 where the window is darker in its first half, else -1.
  HWY_INLINE Floats direction_inwards(const Rays& ray, Floats oldest) const {
    if (sign_ != 0) return all(static_cast<float>(sign_));
    Floats difference = zero();
    for (int first = 0; first < window_; first += kBatch) {
      Floats batch[kBatch];
      volume_.samples_from(ray, oldest + all(static_cast<float>(first)), batch);
      for (int slot = 0; slot < kBatch && first + slot < window_; ++slot) {
        const Floats value = hn::Max(batch[slot], zero());
        difference = first + slot < half_ ? difference - value : difference + value;
      }
    }
    return where(hn::Ge(difference, zero()), all(1.0F), all(-1.0F));
  }

  HWY_INLINE EdgeEchoes echoes_about(const Rays& ray, Floats ray_first, Floats ray_end, Floats position,
                                     Floats (&values)[kMostLevelSamples]) const {
    EdgeEchoes echoes;
    const Floats oldest = oldest_of(position);
    echoes.inwards = direction_inwards(ray, oldest);
    echoes.start =
        where(hn::Gt(echoes.inwards, zero()), oldest, oldest + all(static_cast<float>(window_ - 1)));
    samples_inwards(ray, ray_first, ray_end, echoes, values);
    Floats fluid = all(1e6F);
    Floats tissue = zero();
    Floats brightest = zero();
    for (int last = sizes_.window_samples / 2 + sizes_.short_mean - 1; last < sizes_.samples; ++last)
      brightest = hn::Max(brightest, sum_to(values, last, sizes_.short_mean));
    for (int last = sizes_.mean - 1; last < sizes_.samples; ++last) {
      const Floats sum = sum_to(values, last, sizes_.mean);
      tissue = hn::Max(tissue, sum);
      if (last < sizes_.window_samples) fluid = hn::Min(fluid, sum);
    }
    echoes.fluid = fluid / all(static_cast<float>(sizes_.mean));
    echoes.tissue = tissue / all(static_cast<float>(sizes_.mean));
    echoes.brightest = brightest / all(static_cast<float>(sizes_.short_mean));
    return echoes;
  }

  // 0 to 1, and -1 where fluid and tissue differ too little for a surface.
  HWY_INLINE Floats certainty_by(const EdgeEchoes& echoes) const {
    const Floats beyond = echoes.tissue - echoes.fluid - all(rays_.least_contrast);
    const float certain_beyond = std::min(rays_.least_contrast, kMostUncertain);
    const Floats share = certain_beyond > 0.0F ? hn::Min(beyond / all(certain_beyond), all(1.0F)) : all(1.0F);
    return where(hn::Lt(beyond, zero()), all(-1.0F), share);
  }

  // The level at the front of a sheet, or between the fluid and the tissue behind an edge.
  HWY_INLINE Floats level_of(const Floats* values, const EdgeEchoes& echoes) const {
    Floats peak = zero();
    for (int last = sizes_.short_mean - 1; last < sizes_.samples; ++last)
      peak = hn::Max(peak, sum_to(values, last, sizes_.short_mean));
    peak = peak / all(static_cast<float>(sizes_.short_mean));
    const Floats middle = all(0.5F) * (echoes.fluid + peak);
    Floats brighter = zero();
    for (int each = 0; each < sizes_.samples; ++each)
      brighter = brighter + hn::IfThenElseZero(hn::Gt(values[each], middle), all(1.0F));
    const Floats front =
        clamped(peak - all(rays_.sheet_below), middle, mixed(echoes.fluid, peak, all(kMostSheetRise)));
    return where(hn::Le(brighter, all(static_cast<float>(sizes_.mean))), front,
                 mixed(echoes.fluid, echoes.tissue, all(rays_.rise)));
  }

  // Where the echo first rises past a level, and where it last rose past the foot before; -1: nowhere.
  struct Rise {
    Floats foot;
    Floats level;
  };
  HWY_INLINE Rise rise_through(const Floats* values, Floats foot_level, Floats level) const {
    Rise rise = {all(-1.0F), all(-1.0F)};
    for (int next = 1; next < sizes_.samples; ++next) {
      const Floats before = values[next - 1];
      const Floats after = values[next];
      const Floats step = hn::Max(after - before, all(1e-6F));
      const Floats number = all(static_cast<float>(next - 1));
      const Mask open = hn::Lt(rise.level, zero());
      rise.foot = where(hn::And(open, passes(before, after, foot_level)),
                        number + clamped((foot_level - before) / step, zero(), all(1.0F)), rise.foot);
      rise.level = where(hn::And(open, passes(before, after, level)),
                         number + clamped((level - before) / step, zero(), all(1.0F)), rise.level);
    }
    return rise;
  }
  HWY_INLINE static Mask passes(Floats before, Floats after, Floats level) {
    return hn::And(hn::Lt(before, level), hn::Ge(after, level));
  }

  // Values from a rise to the surface behind it.
  HWY_INLINE Floats reach_behind(const Rise& rise, Floats spacing) const {
    const Floats value_mm = all(static_cast<float>(sizes_.stride)) * spacing;
    const Floats long_mm =
        where(hn::Lt(rise.foot, zero()), zero(), (rise.level - rise.foot) * value_mm - all(kOwnRiseMm));
    const Floats reach_mm = all(rays_.reach) * hn::Max(long_mm, zero());
    return hn::Min(reach_mm, all(static_cast<float>(half_)) * spacing) / value_mm;
  }

  HWY_INLINE Places placed_by_level(const Rays& ray, Floats first, Floats end, Floats position) const {
    Floats values[kMostLevelSamples];
    const EdgeEchoes echoes = echoes_about(ray, first, end, position, values);
    Places places;
    places.certainty = certainty_by(echoes);
    places.surface =
        hn::And(hn::Ge(places.certainty, zero()), hn::Ge(echoes.brightest, all(rays_.least_tissue)));
    const Floats level = hn::Max(level_of(values, echoes), all(rays_.least_tissue));
    const float foot = std::clamp(1.0F - kFoot * (1.0F - rays_.rise), kLeastFoot, kMostFoot);
    const Floats foot_level = hn::Min(mixed(echoes.fluid, echoes.tissue, all(foot)), level);
    const Rise rise = rise_through(values, foot_level, level);
    const Floats found = rise.level + reach_behind(rise, ray.spacing);
    const Floats steps = echoes.inwards * all(static_cast<float>(sizes_.stride)) * found;
    places.position = where(hn::Lt(rise.level, zero()), position, echoes.start + steps);
    return places;
  }

  const shaders::CastParameters& rays_;
  const FanVolume& volume_;
  int window_;
  int half_;
  int place_;
  int sign_;
  PlaceSizes sizes_;
};

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
