// SPDX-License-Identifier: Apache-2.0
// Points, normals and shadow rays of the filtered depth map: shaders/surface_light.h for a vector of pixels.
// See there for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_SHADING_SURFACE_MAP) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_SURFACE_MAP
#undef FANLIGHT_RENDERER_SHADING_SURFACE_MAP
#else
#define FANLIGHT_RENDERER_SHADING_SURFACE_MAP
#endif

#include "renderer/shading/row_access-inl.h"
#include "shaders/bindings.h"
#include "shaders/light_parameters.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

constexpr float kShadowBias = 1.5F;
constexpr float kShadowReach = 1000.0F;
constexpr auto kNoSurface = static_cast<float>(FANLIGHT_NO_SURFACE);
constexpr auto kMostDepth = static_cast<float>(FANLIGHT_MAX_DEPTH);

// Places in the picture: whole numbers, or parts of pixels.
struct Pixels {
  Floats x;
  Floats y;
};

// Of consecutive pixels of a row.
HWY_INLINE Pixels pixels_from(int column, int row) {
  return {hn::Iota(kFloats, static_cast<float>(column)), all(static_cast<float>(row))};
}

// The depths of a pixel and of its four neighbours.
struct Neighbours {
  Floats here;
  Floats left;
  Floats right;
  Floats above;
  Floats below;
};

class SurfaceMap {
 public:
  SurfaceMap(const shaders::LightParameters& lighting, bool perspective, bool soft_shadows,
             const float* depths, float nearest)
      : lighting_(lighting),
        perspective_(perspective),
        soft_shadows_(soft_shadows),
        depths_(depths),
        nearest_(nearest) {}

  bool has_view() const {
    return lighting_.view_left <= lighting_.view_right && lighting_.view_top <= lighting_.view_bottom;
  }
  bool row_in_view(int row) const { return row >= lighting_.view_top && row <= lighting_.view_bottom; }
  // The row of the viewport that is nearest.
  int clamped_row(int row) const { return std::clamp(row, lighting_.view_top, lighting_.view_bottom); }

  Mask in_view(const Pixels& pixel) const {
    const Pixels inside = clamped_to_view(pixel);
    return hn::And(hn::Eq(inside.x, pixel.x), hn::Eq(inside.y, pixel.y));
  }

  // Of whole pixels. FANLIGHT_NO_SURFACE outside the viewport.
  Floats depth_at(const Pixels& pixel) const {
    if (!has_view()) return all(kNoSurface);
    const Pixels inside = clamped_to_view(pixel);
    const Mask known = hn::And(hn::Eq(inside.x, pixel.x), hn::Eq(inside.y, pixel.y));
    return where(known, gathered(inside), all(kNoSurface));
  }

  // Of consecutive pixels of a row; FANLIGHT_NO_SURFACE outside the viewport.
  Floats depths_from(int column, int row) const {
    if (!row_in_view(row)) return all(kNoSurface);
    const Floats depths = clamped_depths_from(column, row);
    if (lies_between(column, lighting_.view_left, lighting_.view_right)) return depths;
    return where(in_view(pixels_from(column, row)), depths, all(kNoSurface));
  }

  // Likewise; outside the viewport those of its border. Precondition: has_view().
  Floats clamped_depths_from(int column, int row) const {
    return read_row(row_of(clamped_row(row)), column, lighting_.view_left, lighting_.view_right);
  }

  Floats view_scale(Floats depth) const {
    return perspective_ ? all(lighting_.view_scale_at_0) + all(lighting_.view_scale_per_mm) * depth
                        : all(1.0F);
  }

  Point point_at(const Pixels& pixel, Floats depth) const {
    const Floats size = all(lighting_.pixel) * view_scale(depth);
    return {(pixel.x - all(lighting_.centre.x)) * size, (all(lighting_.centre.y) - pixel.y) * size,
            negative(depth)};
  }

  Pixels pixel_of(const Point& at) const {
    const Floats scale = all(lighting_.pixel) * view_scale(negative(at.z));
    return {all(lighting_.centre.x) + at.x / scale, all(lighting_.centre.y) - at.y / scale};
  }

  Point normal_at(const Pixels& pixel, const Neighbours& depths) const {
    const Point along = tangent(pixel, 1.0F, 0.0F, depths.here, depths.left, depths.right);
    const Point down = tangent(pixel, 0.0F, 1.0F, depths.here, depths.above, depths.below);
    return normalised(cross(along, scaled(down, all(-1.0F))));
  }

  // From a point towards a light, length 1.
  Point direction_to_light(const Point& at, int lamp) const {
    if (lighting_.directional != 0) return all(lighting_.lamp_directions[lamp]);
    const Point toward = difference(all(lighting_.lamp_places[lamp]), at);
    return scaled(toward, all(1.0F) / hn::Max(length_of(toward), all(1e-6F)));
  }

  // What a shadow leaves of the direct light on a surface that faces the light. `wanted`: the lanes that are.
  Floats direct_light(const Point& at, Floats depth, Mask wanted, int lamp) const {
    if (lighting_.shadow >= 1.0F || is_empty(wanted)) return all(1.0F);
    const Floats seen = light_seen(at, depth, wanted, lamp);
    return where(wanted, mixed(all(lighting_.shadow), all(1.0F), seen), all(1.0F));
  }

  const shaders::LightParameters& lighting() const { return lighting_; }
  bool perspective() const { return perspective_; }

 private:
  const float* row_of(int row) const { return depths_ + static_cast<std::size_t>(row) * lighting_.width; }
  Pixels clamped_to_view(const Pixels& pixel) const {
    return {clamped(pixel.x, all(static_cast<float>(lighting_.view_left)),
                    all(static_cast<float>(lighting_.view_right))),
            clamped(pixel.y, all(static_cast<float>(lighting_.view_top)),
                    all(static_cast<float>(lighting_.view_bottom)))};
  }
  Floats gathered(const Pixels& pixel) const {
    const Integers width = hn::Set(kIntegers, static_cast<std::int32_t>(lighting_.width));
    return hn::GatherIndex(kFloats, depths_, whole(pixel.y) * width + whole(pixel.x));
  }

  Point tangent(const Pixels& pixel, float across, float down, Floats here, Floats before,
                Floats next) const {
    const bool central = lighting_.central_normals != 0;
    Mask has_next = hn::Ge(next, zero());
    Mask has_before = hn::Ge(before, zero());
    if (central) {
      const Floats most = all(lighting_.same_surface);
      has_next = hn::And(has_next, hn::Le(hn::Abs(next - here), most));
      has_before = hn::And(has_before, hn::Le(hn::Abs(before - here), most));
    }
    const Pixels after = {pixel.x + all(across), pixel.y + all(down)};
    const Pixels ahead_of = {pixel.x - all(across), pixel.y - all(down)};
    const Point at = point_at(pixel, here);
    const Mask from_before = central ? has_before : hn::AndNot(has_next, has_before);
    const Point from = where(from_before, point_at(ahead_of, before), at);
    const Point beyond = where(has_before, at, point_at(after, here));
    const Point to = where(has_next, point_at(after, next), beyond);
    return difference(to, from);
  }

  // Fraction of a light that is visible from a point of the height map.
  Floats light_seen(const Point& from, Floats depth, Mask wanted, int lamp) const {
    const bool directional = lighting_.directional != 0;
    const auto& direction = lighting_.lamp_directions[lamp];
    const Point towards = directional ? all(shaders::vec3(direction * kShadowReach))
                                      : difference(all(lighting_.lamp_places[lamp]), from);
    const Floats reach = length_of(towards);
    const Floats distance = directional ? all(lighting_.lamp_distances[lamp]) : hn::Max(reach, all(1e-3F));
    const Floats bias = all(kShadowBias * lighting_.pixel) * view_scale(depth);
    const Point start = {from.x, from.y, from.z + bias};
    const Floats top = all(lighting_.shadow_top);
    const Mask leaves = hn::Gt(start.z + towards.z, top);
    const Mask above = hn::And(leaves, hn::Ge(start.z, top));
    Floats part = where(leaves, (top - start.z) / towards.z, all(1.0F));
    const Floats climb = towards.z - all(lighting_.softness) * reach / distance;
    const Floats to_nearest = all(-nearest_) - start.z;
    const Floats most = hn::Min(part, hn::Max(to_nearest / climb, zero()));
    part = where(hn::Gt(climb, zero()), most, part);
    const Point end = at(start, part, towards);
    return march(start, end, distance, hn::AndNot(above, wanted));
  }

  // Along the ray, one pixel a step.
  Floats march(const Point& start, const Point& end, Floats light_distance, Mask open) const {
    const Pixels first = pixel_of(start);
    const Pixels last = pixel_of(end);
    const Floats across = last.x - first.x;
    const Floats down = last.y - first.y;
    const Floats pixels = hn::Max(hn::Abs(across), hn::Abs(down));
    const Floats step = all(1.0F) / pixels;
    const Floats start_scale = view_scale(negative(start.z));
    const Floats end_scale = view_scale(negative(end.z));
    const Floats blur = all(lighting_.softness) * length_of(difference(end, start)) / light_distance;
    Floats seen = all(1.0F);
    for (float number = 1.0F;; number += 1.0F) {
      open = hn::And(open, hn::And(hn::Lt(all(number), pixels), hn::Gt(seen, zero())));
      if (is_empty(open)) return seen;
      const Floats fraction = all(number) * step;
      const Pixels at = {first.x + fraction * across, first.y + fraction * down};
      open = hn::And(open, in_view_between(at));
      const Floats far = fraction * start_scale;
      const Floats along = perspective_ ? far / (far + (all(1.0F) - fraction) * end_scale) : fraction;
      const Floats height = mixed(start.z, end.z, along);
      const Floats depth = gathered(clamped_to_view(nearest_pixel(at, open)));
      const Floats clearance = where(hn::Ge(depth, zero()), height + depth, all(1e9F));
      const Floats visible =
          soft_shadows_ ? clamped(all(0.5F) + all(0.5F) * clearance / (blur * along), zero(), all(1.0F))
                        : hn::IfThenElseZero(hn::Ge(clearance, zero()), all(1.0F));
      seen = where(open, hn::Min(seen, visible), seen);
    }
  }

  // Whether places lie in the viewport: between the middles of its outer pixels.
  Mask in_view_between(const Pixels& at) const {
    const Mask columns = hn::And(hn::Ge(at.x, all(static_cast<float>(lighting_.view_left))),
                                 hn::Le(at.x, all(static_cast<float>(lighting_.view_right))));
    const Mask rows = hn::And(hn::Ge(at.y, all(static_cast<float>(lighting_.view_top))),
                              hn::Le(at.y, all(static_cast<float>(lighting_.view_bottom))));
    return hn::And(columns, rows);
  }

  // The others may be no numbers: 0.
  static Pixels nearest_pixel(const Pixels& at, Mask wanted) {
    return {hn::IfThenElseZero(wanted, hn::Floor(at.x + all(0.5F))),
            hn::IfThenElseZero(wanted, hn::Floor(at.y + all(0.5F)))};
  }

  const shaders::LightParameters& lighting_;
  bool perspective_;
  bool soft_shadows_;
  const float* depths_;
  float nearest_;  // depth, mm
};

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
