// SPDX-License-Identifier: Apache-2.0
// Bounds the samples of all rays of a tile, a segment a lane: shaders/tile_bounds.h for a vector of segments
// of one tile. See there for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_RAYS_TILE_BOUNDS) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_TILE_BOUNDS
#undef FANLIGHT_RENDERER_RAYS_TILE_BOUNDS
#else
#define FANLIGHT_RENDERER_RAYS_TILE_BOUNDS
#endif

#include <cmath>

#include "renderer/rays/ray_lanes-inl.h"
#include "shaders/cast_parameters.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

constexpr float kSlackFactor = 1.02F;
constexpr float kSlackMm = 0.01F;
constexpr int kOutermost = 8;

// Samples of one ray: first + index * step.
struct RayLine {
  shaders::vec3 first;
  shaders::vec3 step;
};

// The outermost rays of a tile, relative to the ray of its middle.
struct TileLines {
  float widening;
  RayLine middle;
  RayLine outermost[kOutermost];
};

// Segments of the tile's rays: the samples whose index differs from `index` by at most half_length.
struct Cells {
  Floats index;
  float half_length;
};

struct Range {
  Floats first;
  Floats last;
};

// In coordinates of the sweep.
struct Extent {
  Range x;
  Range from_axis;
  Floats half_tangent;
  Floats tangent;
};

class TileBounds {
 public:
  // `beside`: how far beside a ray echoes count, in steps.
  TileBounds(const shaders::CastParameters& rays, const float* angles, int beside)
      : rays_(rays), angles_(angles), beside_(beside) {}

  TileLines lines_of(std::uint32_t tile) const {
    const std::uint32_t side = 8 * rays_.pixel_stride;
    const std::uint32_t across = (rays_.width + side - 1) / side;
    const float reach = 0.5F * static_cast<float>(side - 1);
    const float middle_x = static_cast<float>(side * (tile % across)) + reach;
    const float middle_y = static_cast<float>(side * (tile / across)) + reach;
    const float turn = reach * std::sqrt(dot_of(rays_.right_turn, rays_.right_turn));
    TileLines lines{.widening = turn * turn, .middle = line_of(middle_x, middle_y), .outermost = {}};
    constexpr float kSides[kOutermost][2] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0},
                                             {1, 0},   {-1, 1}, {0, 1},  {1, 1}};
    for (int ray = 0; ray < kOutermost; ++ray) {
      const RayLine line = line_of(middle_x + reach * kSides[ray][0], middle_y + reach * kSides[ray][1]);
      lines.outermost[ray] = {line.first - lines.middle.first, line.step - lines.middle.step};
    }
    return lines;
  }

  Extent extent_of(const TileLines& tile, const Cells& cells) const {
    const Point centre = at(all(tile.middle.first), cells.index, all(tile.middle.step));
    const Floats along = centre.y + all(rays_.motor_radius);
    const Floats from_axis = hn::Sqrt(along * along + centre.z * centre.z);
    const Mask beside_axis = hn::Gt(from_axis, all(1e-6F));
    const Floats unit = all(1.0F) / from_axis;
    const Floats y = where(beside_axis, along * unit, all(1.0F));
    const Floats z = where(beside_axis, centre.z * unit, zero());
    const Floats reach_x = reach_along(tile, cells, {all(1.0F), zero(), zero()});
    const Floats reach_away = reach_along(tile, cells, {zero(), y, z});
    const Floats reach_around = reach_along(tile, cells, {zero(), negative(z), y});
    const Floats nearest = from_axis - reach_away;
    const Floats farthest_away = from_axis + reach_away;
    const Floats farthest = hn::Sqrt(farthest_away * farthest_away + reach_around * reach_around);
    const Floats tangent = hn::Min(reach_around / nearest, all(1e6F));
    return {{centre.x - reach_x, centre.x + reach_x},
            {nearest, farthest},
            centre.z / hn::Max(from_axis + along, all(1e-6F)),
            where(hn::Gt(nearest, zero()), tangent, all(1e6F))};
  }

  // First and last frame that samples of each cell interpolate, whole numbers; last < first: none.
  Range frames_in(const Extent& extent) const {
    const Floats tangent = extent.tangent;
    const Floats widened = tangent / (all(1.0F) + hn::Sqrt(all(1.0F) + tangent * tangent));
    const Floats middle = extent.half_tangent;
    const Floats below = all(1.0F) + middle * widened;
    const Floats above = all(1.0F) - middle * widened;
    const Floats first = where(hn::Le(below, zero()), all(-1e6F), (middle - widened) / below);
    const Floats last = where(hn::Le(above, zero()), all(1e6F), (middle + widened) / above);
    // One more entry on either side, for rounding.
    const Floats first_entry = hn::Max(hn::Floor(table_position(first)) - all(1.0F), zero());
    const Floats last_entry =
        hn::Min(hn::Floor(table_position(last)) + all(2.0F), all(rays_.last_angle_entry));
    const Floats lowest = hn::GatherIndex(kFloats, angles_, whole(first_entry));
    const Floats highest = hn::GatherIndex(kFloats, angles_, whole(last_entry));
    const Mask outside = hn::Or(hn::Lt(highest, zero()), hn::Gt(lowest, all(rays_.last_frame)));
    const Floats most = all(rays_.last_frame);
    const Floats low = hn::Floor(clamped(lowest, zero(), most));
    const Floats high = hn::Min(hn::Floor(clamped(highest, zero(), most)) + all(1.0F), most);
    // A cell that contains the axis reaches every angle.
    const Mask at_axis = hn::Le(extent.from_axis.first, zero());
    return {where(at_axis, zero(), where(outside, zero(), low)),
            where(at_axis, most, where(outside, all(-1.0F), high))};
  }

 private:
  static float dot_of(const shaders::vec3& a, const shaders::vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
  RayLine line_of(float x, float y) const {
    const shaders::vec3 from = rays_.origin + x * rays_.right_step + y * rays_.down_step;
    const shaders::vec3 forward = rays_.forward + x * rays_.right_turn + y * rays_.down_turn;
    return {from + rays_.start * forward, (rays_.step / std::sqrt(dot_of(forward, forward))) * forward};
  }
  Floats table_position(Floats half_tangent) const {
    return clamped(half_tangent * all(rays_.angle_scale) + all(rays_.angle_offset), zero(),
                   all(rays_.last_angle_entry));
  }
  // Half of the extent of each cell along a unit vector, from its centre, mm.
  Floats reach_along(const TileLines& tile, const Cells& cells, const Point& direction) const {
    Floats reach = zero();
    for (const RayLine& line : tile.outermost) {
      const Floats aside = hn::Abs(dot(at(all(line.first), cells.index, all(line.step)), direction));
      const Floats along = hn::Abs(dot(all(tile.middle.step + line.step), direction));
      reach = hn::Max(reach, aside + all(cells.half_length) * along);
    }
    const float across = 1.5F * static_cast<float>(beside_) * rays_.step;
    return all(kSlackFactor + tile.widening) * (reach + all(across)) + all(kSlackMm);
  }

  const shaders::CastParameters& rays_;
  const float* angles_;
  int beside_;
};

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
