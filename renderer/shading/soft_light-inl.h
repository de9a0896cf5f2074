// SPDX-License-Identifier: Apache-2.0
// The soft part of the light, for each 2 x 2 pixels: shaders/soft_light.h, soft_surface.h and
// scattered_light.h for a vector of places. See there for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_SHADING_SOFT_LIGHT) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_SOFT_LIGHT
#undef FANLIGHT_RENDERER_SHADING_SOFT_LIGHT
#else
#define FANLIGHT_RENDERER_SHADING_SOFT_LIGHT
#endif

#include "renderer/shading/halves-inl.h"
#include "renderer/shading/surface_map-inl.h"

// After foreach_target.h.
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

constexpr int kAround = 12;
// shaders/soft_surface.h says where they come from.
constexpr float kSpiral[kAround][2] = {{0.204F, 0.0F},    {-0.261F, 0.239F},  {0.040F, -0.455F},
                                       {0.328F, 0.429F},  {-0.603F, -0.107F}, {0.571F, -0.363F},
                                       {-0.190F, 0.711F}, {-0.366F, -0.700F}, {0.789F, 0.286F},
                                       {-0.822F, 0.335F}, {0.397F, -0.847F},  {0.285F, 0.937F}};
constexpr float kLeastRise = 0.08F;
constexpr float kHidden = 3.0F;
constexpr int kGlowSteps = 24;

// One component for each light that is on: red, green and blue stand for the first, second and third.
HWY_INLINE Floats of_lamp(const Four& four, int lamp) {
  return lamp == 0 ? four.x : lamp == 1 ? four.y : four.z;
}
HWY_INLINE void set_lamp(Four& four, int lamp, Floats value) {
  (lamp == 0 ? four.x : lamp == 1 ? four.y : four.z) = value;
}

// Three maps of half the picture's width and height: direct light and sky; scattered light and depth; and
// the latter after the rows. Two words a place.
class SoftMaps {
 public:
  SoftMaps(const shaders::LightParameters& lighting, std::uint32_t* words)
      : across_((static_cast<int>(lighting.width) + 1) / 2),
        down_((static_cast<int>(lighting.height) + 1) / 2),
        words_(words) {}

  int across() const { return across_; }
  int down() const { return down_; }

  // Of consecutive places of a row; beyond its ends those at the end.
  Four from(int column, int row, int map) const {
    return unpacked(read_pairs(row_of(row, map), column, 0, across_ - 1));
  }
  // Of any places. Precondition: they lie in the map.
  Four at(const Pixels& place, int map) const {
    const Integers first = hn::Set(kIntegers, map * down_ * across_);
    const Integers index = first + whole(place.y) * hn::Set(kIntegers, across_) + whole(place.x);
    return unpacked(gathered_pairs(words_, hn::ShiftLeft<1>(index)));
  }
  void write(const Four& values, int column, int row, int map) const {
    write_pairs(packed(values), row_of(row, map) + 2 * column, across_ - column);
  }

 private:
  std::uint32_t* row_of(int row, int map) const {
    return words_ + 2 *
                        (static_cast<std::size_t>(map) * static_cast<std::size_t>(down_) +
                         static_cast<std::size_t>(row)) *
                        static_cast<std::size_t>(across_);
  }

  int across_;
  int down_;
  std::uint32_t* words_;
};

// 2 x 2 pixels, of which the first that has a surface stands for all.
struct Place {
  Pixels pixel;
  Floats depth;
  Mask present;  // has a surface
  Point normal;
  Floats sky;
  Floats known;
};

class SoftSurface {
 public:
  explicit SoftSurface(const SurfaceMap& map) : map_(map), lighting_(map.lighting()) {}

  // Light and sky, and scattered light and depth, of consecutive places of a row.
  void light(int column, int row, Four& direct, Four& scattered) const {
    direct = {all(1.0F), all(1.0F), all(1.0F), all(1.0F)};
    scattered = {zero(), zero(), zero(), all(kNoSurface)};
    const Place place = place_at(column, row);
    if (is_empty(place.present)) return;
    const Point point = map_.point_at(place.pixel, place.depth);
    for (int lamp = 0; lamp < lighting_.lamps; ++lamp) {
      const Point to_light = map_.direction_to_light(point, lamp);
      const Floats cosine = dot(place.normal, to_light);
      const Mask faces = hn::Gt(cosine, zero());
      const Floats arrives = map_.direct_light(point, place.depth, hn::And(faces, place.present), lamp);
      Floats through = zero();
      const Mask glows = hn::AndNot(faces, place.present);
      if (lighting_.glow > 0.0F && !is_empty(glows))
        through = hn::IfThenElseZero(glows, all(lighting_.glow) * light_through(point, to_light, lamp));
      const Floats entered = hn::Abs(cosine) * where(faces, arrives, through);
      set_lamp(direct, lamp, where(place.present, place.known * arrives, all(1.0F)));
      set_lamp(scattered, lamp, hn::IfThenElseZero(place.present, place.known * entered));
    }
    direct.w = where(place.present, place.known * place.sky, all(1.0F));
    scattered.w = where(place.present, place.depth, all(kNoSurface));
  }

 private:
  Place place_at(int column, int row) const {
    const Pixels first = {hn::Iota(kFloats, static_cast<float>(column)) * all(2.0F),
                          all(static_cast<float>(2 * row))};
    Place place = {first, all(kNoSurface), none(), {zero(), zero(), all(1.0F)}, all(1.0F), all(1.0F)};
    for (int each = 3; each >= 0; --each) {
      const Pixels candidate = {first.x + all(static_cast<float>(each & 1)),
                                first.y + all(static_cast<float>(each >> 1))};
      const Floats depth = map_.depth_at(candidate);
      const Mask known = hn::Ge(depth, zero());
      place.pixel = {where(known, candidate.x, place.pixel.x), where(known, candidate.y, place.pixel.y)};
      place.depth = where(known, depth, place.depth);
    }
    place.present = hn::Ge(place.depth, zero());
    if (is_empty(place.present)) return place;
    const Pixels& at = place.pixel;
    place.normal = map_.normal_at(at, {.here = place.depth,
                                       .left = map_.depth_at({at.x - all(1.0F), at.y}),
                                       .right = map_.depth_at({at.x + all(1.0F), at.y}),
                                       .above = map_.depth_at({at.x, at.y - all(1.0F)}),
                                       .below = map_.depth_at({at.x, at.y + all(1.0F)})});
    if (lighting_.occlusion > 0.0F) place.sky = mixed(all(1.0F), sky_seen(place), all(lighting_.occlusion));
    if (lighting_.fade_reach > 0.0F) place.known = known_around(place);
    return place;
  }

  static Pixels on_spiral(const Place& place, Floats radius, int point) {
    return {place.pixel.x + hn::Floor(radius * all(kSpiral[point][0]) + all(0.5F)),
            place.pixel.y + hn::Floor(radius * all(kSpiral[point][1]) + all(0.5F))};
  }

  Floats sky_seen(const Place& place) const {
    const Point at = map_.point_at(place.pixel, place.depth);
    const Floats reach = all(lighting_.occlusion_reach);
    const Floats radius = reach / (all(lighting_.pixel) * map_.view_scale(place.depth));
    Floats hidden = zero();
    for (int point = 0; point < kAround; ++point) {
      const Pixels there = on_spiral(place, radius, point);
      const Floats depth = map_.depth_at(there);
      const Point away = difference(map_.point_at(there, depth), at);
      const Floats square = dot(away, away);
      const Floats apart = hn::Max(hn::Sqrt(square), all(1e-3F));
      const Floats near = hn::Max(all(1.0F) - square / (reach * reach), zero());
      const Floats rise = hn::Max(dot(away, place.normal) / apart - all(kLeastRise), zero());
      hidden = hidden + hn::IfThenElseZero(hn::Ge(depth, zero()), near * rise);
    }
    return clamped(all(1.0F) - all(kHidden / static_cast<float>(kAround)) * hidden, zero(), all(1.0F));
  }

  Floats known_around(const Place& place) const {
    const Floats radius = all(lighting_.fade_reach) / (all(lighting_.pixel) * map_.view_scale(place.depth));
    Floats known = zero();
    Floats points = zero();
    for (int point = 0; point < kAround; ++point) {
      const Pixels there = on_spiral(place, radius, point);
      points = points + hn::IfThenElseZero(map_.in_view(there), all(1.0F));
      known = known + hn::IfThenElseZero(hn::Ge(map_.depth_at(there), zero()), all(1.0F));
    }
    const Floats share = all(2.0F) * known / hn::Max(points, all(1.0F)) - all(1.0F);
    return where(hn::Gt(points, zero()), clamped(share, zero(), all(1.0F)), all(1.0F));
  }

  // Share of a light that comes through the body to a point.
  Floats light_through(const Point& point, const Point& to_light, int lamp) const {
    const float step = 0.25F * lighting_.glow_reach;
    const Floats distance = lighting_.directional != 0
                                ? all(1e9F)
                                : length_of(difference(all(lighting_.lamp_places[lamp]), point));
    const Floats top = all(lighting_.shadow_top);
    Floats thickness = zero();
    for (int number = 0; number < kGlowSteps; ++number) {
      const Floats along = all((static_cast<float>(number) + 0.5F) * step);
      Point there = at(point, along, to_light);
      const Mask in_body = hn::And(hn::Lt(along, distance), hn::Le(there.z, top));
      there.z = hn::Min(there.z, top);
      const Pixels pixel = map_.pixel_of(there);
      // Beyond any picture is as good as far beyond, and has an index.
      const Pixels nearest = {bounded(hn::Floor(pixel.x + all(0.5F))),
                              bounded(hn::Floor(pixel.y + all(0.5F)))};
      const Floats depth = map_.depth_at(nearest);
      const Floats inside = clamped(all(0.5F) - (there.z + depth) / all(step), zero(), all(1.0F));
      const Mask counts = hn::And(in_body, hn::Ge(depth, zero()));
      thickness = thickness + hn::IfThenElseZero(counts, inside * all(step));
    }
    return hn::Exp(kFloats, negative(thickness) / all(lighting_.glow_reach));
  }

  static Floats bounded(Floats pixel) { return clamped(pixel, all(-1e6F), all(1e6F)); }

  const SurfaceMap& map_;
  const shaders::LightParameters& lighting_;
};

// Scattered light and depth of consecutive places, the light spread along the rows or columns of `map`.
HWY_INLINE Four scattered_light(const SurfaceMap& surface, const SoftMaps& maps, int column, int row, int map,
                                bool columns) {
  const shaders::LightParameters& lighting = surface.lighting();
  const Four here = maps.from(column, row, map);
  const Mask present = hn::Ge(here.w, zero());
  if (is_empty(present)) return here;
  const Floats step = all(2.0F * lighting.pixel) * surface.view_scale(here.w);
  const Floats place = hn::Iota(kFloats, static_cast<float>(column));
  Four sum = {zero(), zero(), zero(), here.w};
  Floats weights = zero();
  for (int each = -lighting.scatter_radius; each <= lighting.scatter_radius; ++each) {
    if (columns && (row + each < 0 || row + each >= maps.down())) continue;
    const Four there = columns ? maps.from(column, row + each, map) : maps.from(column + each, row, map);
    const Floats at = place + all(static_cast<float>(columns ? 0 : each));
    const Mask inside = hn::And(hn::Ge(at, zero()), hn::Lt(at, all(static_cast<float>(maps.across()))));
    const Mask counts = hn::And(inside, hn::Ge(there.w, zero()));
    const Floats across = step * all(static_cast<float>(each));
    const Floats below = there.w - here.w;
    const Floats fall = negative(across * across + below * below) * all(lighting.scatter_fall);
    const Floats weight = hn::IfThenElseZero(counts, hn::Exp(kFloats, fall));
    sum.x = sum.x + weight * there.x;
    sum.y = sum.y + weight * there.y;
    sum.z = sum.z + weight * there.z;
    weights = weights + weight;
  }
  const Mask known = hn::And(present, hn::Gt(weights, zero()));
  return {where(known, sum.x / weights, here.x), where(known, sum.y / weights, here.y),
          where(known, sum.z / weights, here.z), here.w};
}

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
