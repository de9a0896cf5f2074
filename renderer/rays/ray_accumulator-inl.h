// SPDX-License-Identifier: Apache-2.0
// What rays give besides the surface: shaders/ray_accumulator.h for a vector of rays. See there.
#if defined(FANLIGHT_RENDERER_RAYS_RAY_ACCUMULATOR) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_RAY_ACCUMULATOR
#undef FANLIGHT_RENDERER_RAYS_RAY_ACCUMULATOR
#else
#define FANLIGHT_RENDERER_RAYS_RAY_ACCUMULATOR
#endif

#include "renderer/rays/ray_lanes-inl.h"
#include "shaders/bindings.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

// From this opacity on, samples behind change the picture by less than one of 255 levels.
constexpr float kOpaque = 0.997F;

struct Colour {
  Floats red;
  Floats green;
  Floats blue;
};

class RayAccumulator {
 public:
  RayAccumulator(int kept, const float* transfer)
      : kept_(kept),
        transfer_(transfer),
        colour_{zero(), zero(), zero()},
        opacity_(zero()),
        extreme_(all(kept == FANLIGHT_KEEP_MINIMUM ? 2.0F : -1.0F)),
        sum_(zero()),
        count_(zero()) {}

  // Adds one sample, 0 to 1, where it is `shown`.
  HWY_INLINE void add(Floats value, Mask shown) {
    switch (kept_) {
      case FANLIGHT_KEEP_COLOUR:
        composite(value, shown);
        break;
      case FANLIGHT_KEEP_MAXIMUM:
        extreme_ = where(shown, hn::Max(extreme_, value), extreme_);
        break;
      case FANLIGHT_KEEP_MINIMUM:
        extreme_ = where(shown, hn::Min(extreme_, value), extreme_);
        break;
      case FANLIGHT_KEEP_MEAN:
        sum_ = sum_ + hn::IfThenElseZero(shown, value);
        count_ = count_ + hn::IfThenElseZero(shown, all(1.0F));
        break;
      default:
        break;
    }
  }

  // Rays of which no further sample can change the colour.
  Mask complete() const {
    if (kept_ == FANLIGHT_KEEP_NOTHING) return hn::Ge(zero(), zero());
    const bool composites = kept_ == FANLIGHT_KEEP_COLOUR || kept_ == FANLIGHT_KEEP_LAYERS;
    return composites ? hn::Ge(opacity_, all(kOpaque)) : none();
  }

  Floats opacity() const { return opacity_; }
  // Adds a layer of glass: its share of what is seen, and its normal to the right and upwards.
  HWY_INLINE void add_layer(Floats share, Floats right, Floats up) {
    opacity_ = opacity_ + share;
    colour_.red = colour_.red + share * right;
    colour_.green = colour_.green + share * up;
  }

  Colour colour() const {
    if (kept_ == FANLIGHT_KEEP_MAXIMUM) return grey(hn::Max(extreme_, zero()));
    if (kept_ == FANLIGHT_KEEP_MINIMUM) return grey(where(hn::Gt(extreme_, all(1.0F)), zero(), extreme_));
    if (kept_ == FANLIGHT_KEEP_MEAN) return grey(sum_ / hn::Max(count_, all(1.0F)));
    return kept_ == FANLIGHT_KEEP_LAYERS ? layers() : colour_;
  }

 private:
  // For pass 2, not to be shown: the root of the opacity, and the mean normal.
  Colour layers() const {
    const Floats unit = hn::Max(opacity_, all(1e-6F));
    return {hn::Sqrt(opacity_), (all(128.0F) + all(127.0F) * (colour_.red / unit)) / all(255.0F),
            (all(128.0F) + all(127.0F) * (colour_.green / unit)) / all(255.0F)};
  }

  static Colour grey(Floats level) { return {level, level, level}; }

  // A channel of the transfer function, linear between grey levels.
  HWY_INLINE Floats transfer_at(Integers entry, Floats share, int channel) const {
    const Floats below = hn::GatherIndex(kFloats, transfer_ + channel, entry);
    const Floats above = hn::GatherIndex(kFloats, transfer_ + channel + 4, entry);
    return mixed(below, above, share);
  }
  HWY_INLINE void composite(Floats value, Mask shown) {
    const Mask adds = hn::And(shown, hn::Lt(opacity_, all(kOpaque)));
    if (is_empty(adds)) return;
    const Floats level = value * all(255.0F);
    const Floats below = clamped(hn::Floor(level), zero(), all(254.0F));
    const Integers entry = hn::ShiftLeft<2>(whole(below));
    const Floats between = level - below;
    const Floats opacity = transfer_at(entry, between, 3);
    const Floats share = hn::IfThenElseZero(adds, (all(1.0F) - opacity_) * opacity);
    colour_.red = colour_.red + share * transfer_at(entry, between, 0);
    colour_.green = colour_.green + share * transfer_at(entry, between, 1);
    colour_.blue = colour_.blue + share * transfer_at(entry, between, 2);
    opacity_ = opacity_ + share;
  }

  int kept_;
  const float* transfer_;
  Colour colour_;  // composited, premultiplied by opacity; or the normals of layers
  Floats opacity_;
  Floats extreme_;
  Floats sum_;
  Floats count_;
};

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
