// SPDX-License-Identifier: Apache-2.0
// The edges behind the surface, for a surface as glass: shaders/glass_layers.h for a vector of rays. See
// there.
#if defined(FANLIGHT_RENDERER_RAYS_GLASS_LAYERS) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_GLASS_LAYERS
#undef FANLIGHT_RENDERER_RAYS_GLASS_LAYERS
#else
#define FANLIGHT_RENDERER_RAYS_GLASS_LAYERS
#endif

#include "renderer/rays/fan_volume-inl.h"
#include "renderer/rays/ray_accumulator-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

// Opacity of an edge that the ray meets at a right angle, as a share of that of one that it grazes.
constexpr float kFaceOn = 0.03F;

// Samples behind a surface's edge in which its own edge lies.
inline float own_layer(const Method& method) {
  const int half_window = method.window / 2;
  return method.place == FANLIGHT_PLACE_FIRST_CROSSING ? static_cast<float>(half_window) : 1.0F;
}

// In proportion to the growth of the echo about a point: to the right, upwards and along the ray.
HWY_INLINE Point growth_at(const FanVolume& volume, const Rays& ray, const Point& point, int half_window) {
  const int samples = half_window >= 4 ? half_window / 2 : 1;
  const Floats reach = all(static_cast<float>(samples));
  // The axes, and the diagonals of a cube.
  constexpr float kWays[7][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 1},
                                 {1, 1, -1}, {1, -1, 1}, {1, -1, -1}};
  Point growth = {zero(), zero(), zero()};
  for (int number = 0; number < 7; ++number) {
    const auto& way = kWays[number];
    const Point none = {zero(), zero(), zero()};
    const Point right = at(none, reach * all(way[0]), ray.across_right);
    const Point up = at(right, reach * all(way[1]), ray.across_up);
    const Point beside = at(up, reach * all(way[2]) * ray.spacing, ray.forward);
    const Floats before = volume.echo_if_scanned(at(point, all(-1.0F), beside));
    const Floats after = volume.echo_if_scanned(at(point, all(1.0F), beside));
    const Mask known = hn::And(hn::Ge(before, zero()), hn::Ge(after, zero()));
    const Floats rise = hn::IfThenElseZero(known, after - before) * all(number < 3 ? 2.0F : 1.0F);
    growth = at(growth, rise, {all(way[0]), all(way[1]), all(way[2])});
  }
  return growth;
}

// Adds an edge of each of these rays. `growth`: of the echo about it; `height`: of the detector's step.
HWY_INLINE void add_layers(RayAccumulator& accumulator, const Point& growth, Mask rays, Floats height,
                           float level) {
  const Floats size = hn::Sqrt(dot(growth, growth));
  const Floats unit = hn::Max(size, all(1e-6F));
  const Floats along = negative(growth.z) / unit;
  const Floats grazing = hn::IfThenElseZero(hn::Gt(size, zero()), all(1.0F) - hn::Abs(along));
  const Floats strength = clamped(height / hn::Max(all(level), all(1e-6F)) - all(1.0F), zero(), all(1.0F));
  const Floats seen = (all(1.0F) - accumulator.opacity()) * strength *
                      mixed(all(kFaceOn), all(1.0F), grazing * grazing * grazing);
  accumulator.add_layer(hn::IfThenElseZero(rays, seen), negative(growth.x) / unit, negative(growth.y) / unit);
}

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
