// SPDX-License-Identifier: Apache-2.0
// The segments of a tile's rays that can hold an edge or a visible sample: shaders/empty_space.comp, a
// segment a lane. See there for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_RAYS_EMPTY_SPACE) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_EMPTY_SPACE
#undef FANLIGHT_RENDERER_RAYS_EMPTY_SPACE
#else
#define FANLIGHT_RENDERER_RAYS_EMPTY_SPACE
#endif

#include <algorithm>
#include <array>

#include "renderer/rays/fan_volume-inl.h"
#include "renderer/rays/tile_bounds-inl.h"
#include "renderer/rays/tile_search.hpp"
#include "shaders/bindings.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::tile_search::HWY_NAMESPACE {

using namespace ray_caster::HWY_NAMESPACE;

constexpr float kSlackLevel = 1e-4F;
constexpr int kMostSegments = FANLIGHT_MAX_SEGMENTS;

// A bit for each segment.
constexpr std::size_t kMaskWords = FANLIGHT_MAX_SEGMENTS / 32;
using SegmentMask = std::array<std::uint32_t, kMaskWords>;

// Segments that hold the samples from 0 to before `samples`.
inline int segments_before(std::uint32_t samples, std::uint32_t segment_shift) {
  return static_cast<int>((samples + (1U << segment_shift) - 1U) >> segment_shift);
}

// Minimum and maximum grey level of regions, 0 to 255. least > greatest: none.
struct Levels {
  Floats least;
  Floats greatest;

  void add(const Levels& more) {
    least = hn::Min(least, more.least);
    greatest = hn::Max(greatest, more.greatest);
  }
};
HWY_INLINE Levels no_levels() {
  return {all(255.0F), zero()};
}

class EmptySpace {
 public:
  EmptySpace(const Method& method, const Memory& memory)
      : method_(method),
        min_max_(memory.neighbour_min_max),
        rays_(*memory.rays),
        bounds_(*memory.rays, memory.angle_table, memory.rays->across) {}

  SegmentMask mask_of(std::uint32_t tile) const {
    const int count = segments_before(rays_.steps, rays_.segment_shift);
    const TileLines lines = bounds_.lines_of(tile);
    constexpr int kStep = static_cast<int>(kLanes);
    SegmentLevels levels;
    for (int before = 0; before < kMostReach; ++before) levels.set(before - kMostReach, 255.0F, 0.0F);
    for (int segment = 0; segment < count; segment += kStep)
      levels.set(segment, levels_in(boxes_of(lines, segment), count - segment));
    SegmentMask mask = {};
    for (int segment = 0; segment < count; segment += kStep) {
      std::uint32_t bits = bits_of(counts(levels, segment));
      if (count - segment < kStep) bits &= (1U << static_cast<std::uint32_t>(count - segment)) - 1U;
      mask[static_cast<std::size_t>(segment / 32)] |= bits << static_cast<std::uint32_t>(segment % 32);
    }
    return mask;
  }

 private:
  static constexpr int kLeastSegment = 1 << FANLIGHT_MIN_SEGMENT_SHIFT;
  // Segments over which the longest window reaches back.
  static constexpr int kMostReach = (ray_caster::kMostWindow - 1 + kLeastSegment - 1) / kLeastSegment;

  // Of each segment, and of those before the first one.
  class SegmentLevels {
   public:
    void set(int segment, float least, float greatest) {
      least_[kMostReach + segment] = least;
      greatest_[kMostReach + segment] = greatest;
    }
    void set(int first, const Levels& levels) {
      hn::StoreU(levels.least, kFloats, least_ + kMostReach + first);
      hn::StoreU(levels.greatest, kFloats, greatest_ + kMostReach + first);
    }
    Levels from(int first) const {
      return {hn::LoadU(kFloats, least_ + kMostReach + first),
              hn::LoadU(kFloats, greatest_ + kMostReach + first)};
    }

   private:
    float least_[kMostReach + kMostSegments + kLanes];
    float greatest_[kMostReach + kMostSegments + kLanes];
  };

  struct Boxes {  // of voxels, whole numbers, both ends in it
    Range frames;
    Range columns;
    Range rows;
  };

  static Range pixels_between(const Range& at, float last_pixel) {
    const Floats most = all(last_pixel);
    const Mask outside = hn::Or(hn::Lt(at.last, zero()), hn::Gt(at.first, most));
    const Floats first = hn::Floor(clamped(at.first, zero(), most));
    const Floats last = hn::Min(hn::Floor(clamped(at.last, zero(), most)) + all(1.0F), most);
    return {where(outside, zero(), first), where(outside, all(-1.0F), last)};
  }

  Boxes boxes_of(const TileLines& lines, int segment) const {
    const int samples = 1 << rays_.segment_shift;
    const float half = 0.5F * static_cast<float>(samples - 1);
    const Floats number = hn::Iota(kFloats, static_cast<float>(segment));
    const Cells cells = {number * all(static_cast<float>(samples)) + all(half), half};
    const Extent extent = bounds_.extent_of(lines, cells);
    Range across = extent.x;
    Range down = {extent.from_axis.first - all(rays_.motor_radius),
                  extent.from_axis.last - all(rays_.motor_radius)};
    if (method_.frames == FANLIGHT_FRAMES_POLAR) around(across, down);
    const Range columns = {across.first * all(rays_.column_scale) + all(rays_.column_offset),
                           across.last * all(rays_.column_scale) + all(rays_.column_offset)};
    const Range rows = {down.first * all(rays_.row_scale) + all(rays_.row_offset),
                        down.last * all(rays_.row_scale) + all(rays_.row_offset)};
    return {bounds_.frames_in(extent), pixels_between(columns, rays_.last_column),
            pixels_between(rows, rays_.last_row)};
  }

  // The disc around each cell's rectangle in the plane of the frame: angles and distances from the array.
  void around(Range& across, Range& down) const {
    const Floats x = all(0.5F) * (across.first + across.last);
    const Floats y = all(0.5F) * (down.first + down.last) + all(rays_.probe_radius);
    const Floats width = across.last - across.first;
    const Floats height = down.last - down.first;
    const Floats reach = all(0.5F) * hn::Sqrt(width * width + height * height);
    const Floats radius = hn::Sqrt(x * x + y * y);
    const Floats angle = angle_between(x, y, radius);
    const Floats ratio = hn::Min(reach / hn::Max(radius, all(1e-6F)), all(1.0F));
    const Floats widened =
        where(hn::Lt(reach, radius), angle_between(ratio, hn::Sqrt(all(1.0F) - ratio * ratio), all(1.0F)),
              all(4.0F));
    across = {angle - widened, angle + widened};
    down = {radius - reach - all(rays_.probe_radius), radius + reach - all(rays_.probe_radius)};
  }

  // Places to read along one side of each box: `first`, first + step, ... up to `last`, in blocks or frames.
  struct Places {
    Floats first;
    Floats last;
    int most;  // of any box that counts

    Floats place(int number, float step) const {
      return hn::Min(first + all(step * static_cast<float>(number)), last);
    }
  };
  // `counts`: the boxes that are of interest. Others may be read in part.
  static Places places_in(const Range& range, float step, Mask counts) {
    const Floats length = hn::IfThenElseZero(counts, range.last - range.first);
    const Floats steps = hn::Max(hn::Floor(length * all(1.0F / step)), zero());
    const LaneFloats each = stored(steps);
    return {range.first, range.first + steps * all(step),
            1 + static_cast<int>(*std::max_element(each.lane, each.lane + kLanes))};
  }
  static Range blocks_of(const Range& pixels) {
    constexpr float kShare = 1.0F / FANLIGHT_BLOCK;
    return {hn::Floor(pixels.first * all(kShare)), hn::Floor(pixels.last * all(kShare))};
  }

  // Of the voxels in the first `count` boxes. A place may be read twice: that changes no minimum.
  Levels levels_in(const Boxes& boxes, int count) const {
    constexpr auto kBound = static_cast<float>(FANLIGHT_BLOCKS_IN_BOUND);
    const Integers across = hn::Set(kIntegers, blocks_along(rays_.last_column));
    const Integers down = hn::Set(kIntegers, blocks_along(rays_.last_row));
    const Mask empty = hn::Or(
        hn::Lt(boxes.frames.last, boxes.frames.first),
        hn::Or(hn::Lt(boxes.columns.last, boxes.columns.first), hn::Lt(boxes.rows.last, boxes.rows.first)));
    const Mask present = hn::Lt(hn::Iota(kFloats, 0.0F), all(static_cast<float>(count)));
    const Mask filled = hn::AndNot(empty, present);
    const Places frames = places_in(boxes.frames, 1.0F, filled);
    const Places columns = places_in(blocks_of(boxes.columns), kBound, filled);
    const Places rows = places_in(blocks_of(boxes.rows), kBound, filled);
    Words least = hn::Set(kWords, 0xFFU);
    Words greatest = hn::Zero(kWords);
    for (int frame = 0; frame < frames.most; ++frame) {
      const Integers first_row = whole(frames.place(frame, 1.0F)) * down;
      for (int y = 0; y < rows.most; ++y) {
        const Integers row = (first_row + whole(rows.place(y, kBound))) * across;
        for (int x = 0; x < columns.most; ++x) {
          const Words found = hn::GatherIndex(kWords, min_max_, row + whole(columns.place(x, kBound)));
          least = hn::Min(least, hn::And(found, hn::Set(kWords, 0xFFU)));
          greatest = hn::Max(greatest, hn::ShiftRight<8>(found));
        }
      }
    }
    const Levels none_found = no_levels();
    return {where(empty, none_found.least, small_number_of(least)),
            where(empty, none_found.greatest, small_number_of(greatest))};
  }

  static int blocks_along(float last_pixel) {
    return (static_cast<int>(last_pixel) + FANLIGHT_BLOCK) / FANLIGHT_BLOCK;
  }

  // Which of the segments from `first` on can hold an edge, or a visible sample.
  Mask counts(const SegmentLevels& levels, int first) const {
    const int half = method_.window / 2;
    const int newest_reach = (half - 1 + kLeastSegment - 1) / kLeastSegment;
    const int oldest_reach = (method_.window - 1 + kLeastSegment - 1) / kLeastSegment;
    Levels newest = no_levels();
    Levels oldest = no_levels();
    for (int back = 0; back <= newest_reach; ++back) newest.add(levels.from(first - back));
    for (int back = half >> rays_.segment_shift; back <= oldest_reach; ++back)
      oldest.add(levels.from(first - back));
    const Floats unit = all(1.0F / 255.0F);
    const Floats rise = (newest.greatest - oldest.least) * unit;
    const Floats fall = (oldest.greatest - newest.least) * unit;
    const Floats edge = rays_.edge_sign > 0 ? rise : rays_.edge_sign < 0 ? fall : hn::Max(rise, fall);
    const Mask holds_edge = hn::Gt(edge + all(kSlackLevel), all(rays_.threshold));
    if (method_.kept != FANLIGHT_KEEP_COLOUR) return holds_edge;
    const Levels here = levels.from(first);
    const Mask visible = hn::And(hn::Ge(here.greatest * unit, all(rays_.least_seen - kSlackLevel)),
                                 hn::Le(here.least * unit, all(rays_.greatest_seen + kSlackLevel)));
    return hn::Or(holds_edge, visible);
  }

  const Method& method_;
  const std::uint32_t* min_max_;
  const shaders::CastParameters& rays_;
  TileBounds bounds_;
};

}  // namespace fanlight::tile_search::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
