// SPDX-License-Identifier: Apache-2.0
// Samples the volume at points of the body: shaders/fan_volume.h, angle_table.h, cut_mask.h and
// sample_batch.h for a vector of rays, with the same steps in the same order. See there.
#if defined(FANLIGHT_RENDERER_RAYS_FAN_VOLUME) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_FAN_VOLUME
#undef FANLIGHT_RENDERER_RAYS_FAN_VOLUME
#else
#define FANLIGHT_RENDERER_RAYS_FAN_VOLUME
#endif

#include "renderer/rays/ray_caster.hpp"
#include "renderer/rays/ray_lanes-inl.h"
#include "shaders/bindings.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

// Consecutive samples of a ray that are read at once: they do not depend on each other, and short vectors
// leave room for more of them in the registers.
constexpr int kBatch = kLanes >= 16 ? 2 : 4;

// The rays of a vector.
struct Rays {
  Point from;
  Point forward;
  Floats spacing;  // mm of depth between samples
  // Steps of the window across the ray.
  Point across_right;
  Point across_up;
};

// The angle of (across, along), whose length is given, about the second axis: angle_between() of
// fan_volume.h.
HWY_INLINE Floats angle_between(Floats across, Floats along, Floats length) {
  const Floats half_tangent = across / hn::Max(length + along, all(1e-6F));
  const Floats t = half_tangent / (all(1.0F) + hn::Sqrt(all(1.0F) + half_tangent * half_tangent));
  const Floats u = t * t;
  Floats series = all(1.0F / 13.0F);
  series = all(1.0F / 11.0F) - u * series;
  series = all(1.0F / 9.0F) - u * series;
  series = all(1.0F / 7.0F) - u * series;
  series = all(1.0F / 5.0F) - u * series;
  series = all(1.0F / 3.0F) - u * series;
  return all(4.0F) * t * (all(1.0F) - u * series);
}

class FanVolume {
 public:
  FanVolume(const Method& method, const Memory& memory)
      : rays_(*memory.rays),
        frames_(method.frames),
        across_(method.across),
        packed_(memory.packed_columns),
        angles_(memory.angle_table),
        cells_(memory.cut_cells) {}

  // The samples `first`, first + 1, ...: 0 to 1, and -1 where nothing was scanned.
  HWY_INLINE void samples_from(const Rays& ray, Floats first, Floats (&values)[kBatch]) const {
    Point points[kBatch];
    for (int slot = 0; slot < kBatch; ++slot) {
      const Floats t = all(rays_.start) + (first + all(static_cast<float>(slot))) * ray.spacing;
      points[slot] = at(ray.from, t, ray.forward);
    }
    if (across_ > 0) return means_across(ray, points, values);
    echoes_at(points, values);
    for (int slot = 0; slot < kBatch; ++slot) values[slot] = exact(values[slot]);
  }

  // The echo at any point, 0 to 1; negative where nothing was scanned. Rays are cut to the frames, but points
  // beside them are not.
  HWY_INLINE Floats echo_if_scanned(const Point& point) const {
    return where(is_between_frames(point), echo(point), all(-1.0F));
  }

  HWY_INLINE Floats from_axis_of(const Point& point) const {
    const Floats along_axis = point.y + all(rays_.motor_radius);
    return hn::Sqrt(along_axis * along_axis + point.z * point.z);
  }

  // Clips the interval of a ray to the region between the first and last frame.
  HWY_INLINE Interval between_frames(Interval part, const Point& from, const Point& forward) const {
    const Floats along = from.y + all(rays_.motor_radius);
    const auto across = [&](Floats y, Floats z, float by_y, float by_z)
                            HWY_ATTR { return y * all(by_y) + z * all(by_z); };
    const shaders::vec2 first = {-rays_.first_angle.y, rays_.first_angle.x};
    const shaders::vec2 last = {rays_.last_angle.y, -rays_.last_angle.x};
    part = cut(part, across(along, from.z, first.x, first.y), across(forward.y, forward.z, first.x, first.y));
    return cut(part, across(along, from.z, last.x, last.y), across(forward.y, forward.z, last.x, last.y));
  }

  // Clips the interval of a ray to the crop box and both clip planes.
  HWY_INLINE Interval cropped(Interval part, const Point& from, const Point& forward) const {
    const Floats starts[] = {from.x, from.y, from.z};
    const Floats steps[] = {forward.x, forward.y, forward.z};
    for (int axis = 0; axis < 3; ++axis) {
      part = cut(part, starts[axis] - all(rays_.crop_lowest[axis]), steps[axis]);
      part = cut(part, all(rays_.crop_highest[axis]) - starts[axis], negative(steps[axis]));
    }
    for (const shaders::vec4* const plane : {&rays_.clip1, &rays_.clip2}) {
      const Point normal = {all(plane->x), all(plane->y), all(plane->z)};
      part = cut(part, dot(normal, from) - all(plane->w), dot(normal, forward));
    }
    return part;
  }

  bool has_cuts() const { return rays_.cut_columns > 0; }
  // Precondition: has_cuts().
  HWY_INLINE Mask is_cut(const Point& point) const {
    const Floats side = all(rays_.cut_cell);
    const Share x = share_of((point.x - all(rays_.cut_lowest.x)) / side, rays_.cut_columns);
    const Share y = share_of((point.y - all(rays_.cut_lowest.y)) / side, rays_.cut_rows);
    const Share z = share_of((point.z - all(rays_.cut_lowest.z)) / side, rays_.cut_layers);
    const Integers row = whole(z.cell) * hn::Set(kIntegers, rays_.cut_rows) + whole(y.cell);
    const Words index = hn::BitCast(kWords, row * hn::Set(kIntegers, rays_.cut_columns) + whole(x.cell));
    const Words four_cells =
        hn::GatherIndex(kWords, cells_, hn::BitCast(kIntegers, hn::ShiftRight<2>(index)));
    const Words bytes = hn::ShiftLeft<3>(hn::And(index, hn::Set(kWords, 3)));
    const Words corners = hn::Shr(four_cells, bytes);
    const Floats rows_mixed[] = {mixed(mixed(corner<0>(corners), corner<4>(corners), z.part),
                                       mixed(corner<2>(corners), corner<6>(corners), z.part), y.part),
                                 mixed(mixed(corner<1>(corners), corner<5>(corners), z.part),
                                       mixed(corner<3>(corners), corner<7>(corners), z.part), y.part)};
    return hn::Ge(mixed(rows_mixed[0], rows_mixed[1], x.part), all(0.5F));
  }

  // The share that is left of the certainty of a surface at `point`: the beam showed only the side that it
  // came from (cast.comp).
  HWY_INLINE Floats seen_by_beam(const Point& point, const Point& forward) const {
    const Floats from_axis = from_axis_of(point);
    const Floats from_apex =
        hn::Max(from_axis - all(rays_.motor_radius) + all(rays_.probe_radius), all(1e-6F));
    const Floats least = hn::Max(from_axis, all(1e-6F));
    const Point beam = {point.x / from_apex, (point.y + all(rays_.motor_radius)) / least, point.z / least};
    const Floats along = dot(beam, forward) / hn::Sqrt(dot(beam, beam) * dot(forward, forward));
    constexpr float kBehind = -0.866F;
    const Floats share = (along - all(kBehind)) / all(-0.5F - kBehind);
    return clamped(share, all(rays_.least_seen_by_beam), all(1.0F));
  }

 private:
  // A place along one axis of the cut cells.
  struct Share {
    Floats cell;
    Floats part;
  };
  HWY_INLINE Share share_of(Floats place, int cells) const {
    const Floats cell = clamped(hn::Floor(place), zero(), all(static_cast<float>(cells - 1)));
    return {cell, clamped(place - cell, zero(), all(1.0F))};
  }
  template <int kBit>
  HWY_INLINE Floats corner(Words corners) const {
    return floats_of(hn::And(hn::ShiftRight<kBit>(corners), hn::Set(kWords, 1)));
  }
  // Of values below 2^31.
  HWY_INLINE static Floats floats_of(Words values) {
    return hn::ConvertTo(kFloats, hn::BitCast(kIntegers, values));
  }

  HWY_INLINE Floats echo(const Point& point) const {
    const Floats from_axis = from_axis_of(point);
    const VoxelPosition position = position_in_frame(point, from_axis, frame_at(point, from_axis));
    return echo_of(voxels_at(position), position.scanned);
  }

  // echo() of several points that do not depend on each other.
  HWY_INLINE void echoes_at(const Point (&points)[kBatch], Floats (&values)[kBatch]) const {
    Floats from_axis[kBatch];
    Floats frame[kBatch];
    for (int slot = 0; slot < kBatch; ++slot) from_axis[slot] = from_axis_of(points[slot]);
    for (int slot = 0; slot < kBatch; ++slot) frame[slot] = frame_at(points[slot], from_axis[slot]);
    VoxelPosition positions[kBatch];
    Voxels voxels[kBatch];
    for (int slot = 0; slot < kBatch; ++slot)
      positions[slot] = position_in_frame(points[slot], from_axis[slot], frame[slot]);
    for (int slot = 0; slot < kBatch; ++slot) voxels[slot] = voxels_at(positions[slot]);
    for (int slot = 0; slot < kBatch; ++slot) values[slot] = echo_of(voxels[slot], positions[slot].scanned);
  }

  // The means across the ray of sample_at() of ray.h.
  HWY_INLINE void means_across(const Rays& ray, const Point (&middles)[kBatch],
                               Floats (&means)[kBatch]) const {
    Floats counts[kBatch];
    for (int slot = 0; slot < kBatch; ++slot) means[slot] = counts[slot] = zero();
    for (int number = 0; number < FANLIGHT_ACROSS_POINTS * across_; ++number) {
      const shaders::vec2 aside = rays_.across_points[number];
      Point points[kBatch];
      Floats echoes[kBatch];
      for (int slot = 0; slot < kBatch; ++slot) {
        points[slot] = at(at(middles[slot], all(aside.x), ray.across_right), all(aside.y), ray.across_up);
      }
      echoes_at(points, echoes);
      for (int slot = 0; slot < kBatch; ++slot) {
        const Mask known = hn::And(hn::Ge(echoes[slot], zero()), is_between_frames(points[slot]));
        means[slot] = means[slot] + hn::IfThenElseZero(known, echoes[slot]);
        counts[slot] = counts[slot] + hn::IfThenElseZero(known, all(1.0F));
      }
    }
    for (int slot = 0; slot < kBatch; ++slot) {
      const Floats from_axis = from_axis_of(middles[slot]);
      const Mask within = position_in_frame(middles[slot], from_axis, zero()).scanned;
      const Mask known = hn::And(within, hn::Gt(counts[slot], zero()));
      means[slot] = exact(where(known, means[slot] / hn::Max(counts[slot], all(1.0F)), all(-1.0F)));
    }
  }

  HWY_INLINE Mask is_between_frames(const Point& point) const {
    const Floats along = point.y + all(rays_.motor_radius);
    const Floats behind_first = point.z * all(rays_.first_angle.x) - along * all(rays_.first_angle.y);
    const Floats before_last = along * all(rays_.last_angle.y) - point.z * all(rays_.last_angle.x);
    return hn::Ge(hn::Min(behind_first, before_last), zero());
  }

  HWY_INLINE static Floats exact(Floats value) {
    return hn::Floor(value * all(524288.0F) + all(0.5F)) * all(1.0F / 524288.0F);
  }

  HWY_INLINE Floats frame_at(const Point& point, Floats from_axis) const {
    const Floats along = point.y + all(rays_.motor_radius);
    const Floats half_tangent = point.z / hn::Max(from_axis + along, all(1e-6F));
    const Floats position = clamped(half_tangent * all(rays_.angle_scale) + all(rays_.angle_offset), zero(),
                                    all(rays_.last_angle_entry));
    const Floats below = hn::Min(hn::Floor(position), all(rays_.last_angle_entry - 1.0F));
    const WordPairs entries = gathered_pairs(angles_, whole(below));
    const Floats frame =
        mixed(hn::BitCast(kFloats, entries.first), hn::BitCast(kFloats, entries.second), position - below);
    return clamped(frame, zero(), all(rays_.last_frame));
  }

  // A point in voxels, and whether it was scanned.
  struct VoxelPosition {
    Floats column;
    Floats row;
    Floats frame;
    Mask scanned;
  };
  HWY_INLINE VoxelPosition position_in_frame(const Point& point, Floats from_axis, Floats frame) const {
    const Floats rho = from_axis - all(rays_.motor_radius);
    const Floats from_apex = rho + all(rays_.probe_radius);
    const Floats reach = point.x * point.x + from_apex * from_apex;
    VoxelPosition position;
    position.frame = frame;
    if (frames_ == FANLIGHT_FRAMES_POLAR) {
      const Floats radius = hn::Sqrt(reach);
      const Floats angle = angle_between(point.x, from_apex, radius);
      position.column = angle * all(rays_.column_scale) + all(rays_.column_offset);
      position.row = (radius - all(rays_.probe_radius)) * all(rays_.row_scale) + all(rays_.row_offset);
    } else {
      position.column = point.x * all(rays_.column_scale) + all(rays_.column_offset);
      position.row = rho * all(rays_.row_scale) + all(rays_.row_offset);
    }
    const Floats beside = from_apex * all(rays_.sector_tangent) - hn::Abs(point.x) - all(rays_.sector_margin);
    const Floats within =
        hn::Min(reach - all(rays_.sector_near_squared), all(rays_.sector_far_squared) - reach);
    const Floats from_side = hn::Min(position.column, all(rays_.last_column) - position.column);
    const Floats from_end = hn::Min(position.row, all(rays_.last_row) - position.row);
    position.scanned = hn::Ge(hn::Min(hn::Min(beside, within), hn::Min(from_side, from_end)), zero());
    return position;
  }

  // The words around a position: two columns of two frames. The upper of the two rows begins at bit `shift`.
  struct Voxels {
    WordPairs front;
    WordPairs back;
    Words shift;
    Floats across;
    Floats down;
    Floats behind;
  };
  HWY_INLINE Voxels voxels_at(const VoxelPosition& position) const {
    const Floats column = clamped(position.column, zero(), all(rays_.last_column));
    const Floats row = clamped(position.row, zero(), all(rays_.last_row));
    const Floats first_column = hn::Floor(column);
    const Floats first_row = hn::Floor(row);
    const Floats first_frame = hn::Floor(position.frame);
    const Floats packed_row = hn::Floor((first_row + all(0.5F)) * all(1.0F / 3.0F));
    const Floats rows = first_frame * all(static_cast<float>(rays_.packed_rows)) + packed_row;
    const Integers here = whole(rows) * hn::Set(kIntegers, rays_.packed_stride) + whole(first_column);
    const Integers behind = here + hn::Set(kIntegers, rays_.packed_rows * rays_.packed_stride);
    return {gathered_pairs(packed_, here),
            gathered_pairs(packed_, behind),
            hn::BitCast(kWords, whole(all(8.0F) * (first_row - all(3.0F) * packed_row))),
            column - first_column,
            row - first_row,
            position.frame - first_frame};
  }

  // The voxels mixed: 0 to 1, and -1 where one of them was not scanned.
  HWY_INLINE Floats echo_of(const Voxels& voxels, Mask scanned) const {
    const Words words[] = {
        hn::Shr(voxels.front.first, voxels.shift), hn::Shr(voxels.front.second, voxels.shift),
        hn::Shr(voxels.back.first, voxels.shift), hn::Shr(voxels.back.second, voxels.shift)};
    if (frames_ == FANLIGHT_FRAMES_MASKED) {
      const Words darkest =
          hn::Min(hn::Min(darker(words[0]), darker(words[1])), hn::Min(darker(words[2]), darker(words[3])));
      scanned = hn::And(scanned, hn::Gt(floats_of(darkest), zero()));
    }
    const Floats down = voxels.down;
    const Floats near = mixed(rows_mixed(words[0], down), rows_mixed(words[1], down), voxels.across);
    const Floats far = mixed(rows_mixed(words[2], down), rows_mixed(words[3], down), voxels.across);
    const Floats value = mixed(near, far, voxels.behind) * all(1.0F / 255.0F);
    return where(scanned, value, all(-1.0F));
  }

  HWY_INLINE static Words upper_row(Words word) { return hn::And(word, hn::Set(kWords, 0xFF)); }
  HWY_INLINE static Words lower_row(Words word) { return upper_row(hn::ShiftRight<8>(word)); }
  HWY_INLINE static Words darker(Words word) { return hn::Min(upper_row(word), lower_row(word)); }
  HWY_INLINE static Floats rows_mixed(Words word, Floats share) {
    return mixed(floats_of(upper_row(word)), floats_of(lower_row(word)), share);
  }

  const shaders::CastParameters& rays_;
  int frames_;
  int across_;
  const std::uint32_t* packed_;
  const float* angles_;
  const std::uint32_t* cells_;
};

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
