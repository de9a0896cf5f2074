// SPDX-License-Identifier: Apache-2.0
#include "renderer/rays/ray_caster.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "shaders/bindings.h"

// Highway includes this file once for each instruction set. Without those whose vectors have no fixed length,
// which cannot be members, and those between SSE2 and AVX2, which gather nothing either.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SSE4 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/rays/ray_caster.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "renderer/rays/edge_detector-inl.h"
#include "renderer/rays/edge_queue-inl.h"
#include "renderer/rays/fan_volume-inl.h"
#include "renderer/rays/glass_layers-inl.h"
#include "renderer/rays/ray_accumulator-inl.h"
#include "renderer/rays/segments.hpp"
#include "renderer/rays/surface_place-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::ray_caster::HWY_NAMESPACE {

// The pixels of a vector of rays: 4 x 4, 4 x 2 or 4 x 1 of a tile, or one.
constexpr std::uint32_t kBlockWidth = std::min<std::uint32_t>(4, kLanes);
constexpr std::uint32_t kBlockHeight = static_cast<std::uint32_t>(kLanes) / kBlockWidth;
constexpr std::uint32_t kTileSide = 8;
constexpr auto kNoSurface = static_cast<float>(FANLIGHT_NO_SURFACE);

// The rays of a block of pixels.
struct Block {
  Rays rays;
  Interval shown;  // depths, mm
  Floats first;    // samples that can change a result: from `first` to before `end`
  Floats end;
  Mask present;  // lanes that have a ray
};

// Results of a block.
struct BlockResult {
  Floats surface;  // depth, mm, or FANLIGHT_NO_SURFACE
  Floats certainty;
  Colour colour;
  int sample_end = 0;       // the first sample that was not read
  std::uint32_t taken = 0;  // samples that were read
};

// Casts the rays of one block, which read the samples of the same numbers at the same time. A ray that has
// found an edge reads on until all have, since reading more samples changes no result.
class BlockCast {
 public:
  BlockCast(const Method& method, const Memory& memory, const FanVolume& volume, const SurfacePlacer& placer,
            const Segments& segments, const Block& block)
      : method_(method),
        parameters_(*memory.rays),
        volume_(volume),
        placer_(placer),
        segments_(segments),
        block_(block),
        detector_(method, memory.rays->threshold),
        accumulator_(method.kept, memory.transfer),
        open_(hn::And(block.present, hn::Lt(block.first, block.end))),
        found_(none()),
        surface_(all(kNoSurface)),
        certainty_(all(1.0F)),
        tried_(all(-1.0F)),
        last_layer_(all(-1.0F)) {}

  BlockResult cast() {
    set_range();
    while (true) {
      read_until_edges();
      if (index_ >= end_) add_edges(detector_.edges().last(), detector_.layers().last());
      place_edges();
      if (method_.kept == FANLIGHT_KEEP_LAYERS) add_layers();
      if (index_ >= end_ || is_empty(hn::Or(open_, uncomposited()))) break;
    }
    certainty_ = certainty_ * volume_.seen_by_beam(at(block_.rays.from, surface_, block_.rays.forward),
                                                   block_.rays.forward);
    return {surface_, certainty_, accumulator_.colour(), index_, taken_};
  }

 private:
  // The samples of all rays together.
  void set_range() {
    const LaneFloats firsts = stored(where(open_, block_.first, all(1e9F)));
    const LaneFloats ends = stored(hn::IfThenElseZero(open_, block_.end));
    float first = 1e9F;
    float end = 0.0F;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      first = std::min(first, firsts.lane[lane]);
      end = std::max(end, ends.lane[lane]);
    }
    end_ = static_cast<int>(end);
    index_ = std::min(static_cast<int>(first), end_);
  }

  // Rays that have a surface, and whose colour is not complete.
  Mask uncomposited() const { return hn::AndNot(accumulator_.complete(), found_); }
  // Rays with an edge that has not ended, and that may count.
  Mask pending() const {
    const Mask layers = hn::And(hn::Or(open_, uncomposited()), detector_.layers().pending());
    return hn::Or(hn::And(open_, detector_.edges().pending()), layers);
  }
  // Whether edges have to be placed before anything else is read.
  bool stops() const {
    const Mask seeking = hn::AndNot(edges_.waiting(), open_);
    const Mask reading = hn::AndNot(layers_.waiting(), uncomposited());
    return edges_.full() || layers_.full() || is_empty(hn::Or(seeking, reading));
  }

  // Reads samples until the rays end, or stops().
  void read_until_edges() {
    while (index_ < end_) {
      int run_end = method_.skips ? index_ : end_;
      if (method_.skips && is_empty(pending())) run_end = begin_run();
      // A run continues where an edge is pending: its peak may lie in the next segment.
      while (index_ < end_ && (index_ < run_end || !is_empty(pending()))) {
        read_batch();
        if (stops()) return;
      }
    }
    index_ = end_;
  }

  // Goes to the next run of segments, and returns its end. It begins one window earlier, so that the
  // detector's window is full in the first segment.
  int begin_run() {
    const int next = segments_.first_sample_in(index_, false);
    const int first = next >= end_ ? end_ : std::max(next - method_.window, index_);
    if (first > index_) detector_.restart();
    index_ = first;
    return next >= end_ ? end_ : std::min(end_, segments_.first_sample_in(next, true));
  }

  void read_batch() {
    const Floats first = all(static_cast<float>(index_));
    Floats batch[kBatch];
    volume_.samples_from(block_.rays, first, batch);
    taken_ += kBatch * static_cast<std::uint32_t>(kLanes);
    for (int slot = 0; slot < kBatch; ++slot) {
      const Floats index = all(static_cast<float>(index_ + slot));
      const Mask in_ray = hn::And(hn::Ge(index, block_.first), hn::Lt(index, block_.end));
      const Mask scanned = hn::And(in_ray, hn::Ge(batch[slot], zero()));
      const Floats value = hn::IfThenElseZero(scanned, batch[slot]);
      FoundEdges layers = {none(), zero(), zero()};
      const FoundEdges edges = detector_.advance(value, scanned, index, layers);
      add_edges(edges, layers);
      if (method_.kept != FANLIGHT_KEEP_NOTHING && method_.kept != FANLIGHT_KEEP_LAYERS)
        accumulate(value, scanned, index);
    }
    index_ += kBatch;
  }

  HWY_INLINE void accumulate(Floats value, Mask scanned, Floats index) {
    const Floats t = all(parameters_.start) + index * block_.rays.spacing;
    Mask kept = hn::And(scanned, in_shown(t));
    if (volume_.has_cuts() && !is_empty(kept))
      kept = hn::AndNot(volume_.is_cut(at(block_.rays.from, t, block_.rays.forward)), kept);
    accumulator_.add(value, kept);
  }

  HWY_INLINE Mask in_shown(Floats t) const {
    return hn::And(hn::Ge(t, block_.shown.first), hn::Le(t, block_.shown.last));
  }

  Mask is_shown(Floats position) const {
    return in_shown(all(parameters_.start) + position * block_.rays.spacing);
  }

  // Queues those edges that may be surfaces, or layers behind one: not cropped, and behind those before them.
  HWY_INLINE void add_edges(const FoundEdges& edges, const FoundEdges& layers) {
    const Mask found = hn::And(open_, edges.found);
    if (!is_empty(found)) {
      const Mask behind = hn::Gt(edges.position, tried_);
      const Mask tries = hn::And(found, hn::And(is_shown(edges.position), behind));
      tried_ = where(tries, edges.position, tried_);
      edges_.add(tries, edges);
    }
    const Mask after_surface = hn::Or(uncomposited(), hn::And(open_, edges_.waiting()));
    const Mask found_layers = hn::And(after_surface, layers.found);
    if (!is_empty(found_layers)) layers_.add(hn::And(found_layers, is_shown(layers.position)), layers);
  }

  // Places the queued edges of each ray until one is a surface.
  void place_edges() {
    for (Mask rays = hn::And(open_, edges_.waiting()); !is_empty(rays);
         rays = hn::And(open_, edges_.waiting())) {
      const Floats edge = edges_.take(rays).position;
      const Places places = placer_.place(block_.rays, block_.first, block_.end, edge);
      const Floats t = all(parameters_.start) + places.position * block_.rays.spacing;
      const Floats depth = clamped(t, block_.shown.first, block_.shown.last);
      Mask surfaces = hn::And(rays, places.surface);
      if (volume_.has_cuts())
        surfaces = hn::AndNot(volume_.is_cut(at(block_.rays.from, depth, block_.rays.forward)), surfaces);
      surface_ = where(surfaces, depth, surface_);
      certainty_ = where(surfaces, places.certainty, certainty_);
      found_ = hn::Or(found_, surfaces);
      open_ = hn::AndNot(surfaces, open_);
      last_layer_ = where(surfaces, edge + all(own_layer(method_)), last_layer_);
      edges_.clear(surfaces);
    }
    layers_.clear(open_);  // they lie before the surface
  }

  // Adds the queued layers of rays that have a surface, front to back.
  void add_layers() {
    for (Mask rays = hn::And(uncomposited(), layers_.waiting()); !is_empty(rays);
         rays = hn::And(uncomposited(), layers_.waiting())) {
      const FoundEdges layers = layers_.take(rays);
      const Mask behind = hn::And(rays, hn::Gt(layers.position, last_layer_));
      last_layer_ = where(behind, layers.position, last_layer_);
      const Floats t = all(parameters_.start) + layers.position * block_.rays.spacing;
      const Point point = at(block_.rays.from, t, block_.rays.forward);
      Mask kept = behind;
      if (volume_.has_cuts()) kept = hn::AndNot(volume_.is_cut(point), kept);
      if (is_empty(kept)) continue;
      const Point growth = growth_at(volume_, block_.rays, point, method_.window / 2);
      HWY_NAMESPACE::add_layers(accumulator_, growth, kept, layers.height, detector_.level());
    }
    layers_.clear(found_);  // of rays that see nothing behind
  }

  const Method& method_;
  const shaders::CastParameters& parameters_;
  const FanVolume& volume_;
  const SurfacePlacer& placer_;
  const Segments& segments_;
  const Block& block_;
  EdgeDetector detector_;
  RayAccumulator accumulator_;
  EdgeQueue edges_;
  EdgeQueue layers_;
  Mask open_;   // rays that seek a surface
  Mask found_;  // rays that have one
  Floats surface_;
  Floats certainty_;
  Floats tried_;       // the last edge that was queued
  Floats last_layer_;  // the last layer that was added
  int index_ = 0;
  int end_ = 0;
  std::uint32_t taken_ = 0;
};

// The depth at which rays start to show anything: linear between the points of near_tissue.h.
HWY_INLINE Floats start_of_rays(const shaders::NearTissueParameters& near, Floats column, Floats row) {
  constexpr auto kLast = static_cast<float>(FANLIGHT_RAY_STARTS - 1);
  const Floats across = clamped(column * all(near.start_columns), zero(), all(kLast));
  const Floats down = clamped(row * all(near.start_rows), zero(), all(kLast));
  const Floats first_across = hn::Min(hn::Floor(across), all(kLast - 1.0F));
  const Floats first_down = hn::Min(hn::Floor(down), all(kLast - 1.0F));
  const Integers upper = whole(first_down) * hn::Set(kIntegers, FANLIGHT_RAY_STARTS) + whole(first_across);
  const WordPairs above = gathered_pairs(near.ray_start, upper);
  const WordPairs below = gathered_pairs(near.ray_start, upper + hn::Set(kIntegers, FANLIGHT_RAY_STARTS));
  const Floats share = across - first_across;
  return mixed(mixed(hn::BitCast(kFloats, above.first), hn::BitCast(kFloats, above.second), share),
               mixed(hn::BitCast(kFloats, below.first), hn::BitCast(kFloats, below.second), share),
               down - first_down);
}

class TileCast {
 public:
  TileCast(const Method& method, const Memory& memory)
      : method_(method),
        memory_(memory),
        rays_(*memory.rays),
        volume_(method, memory),
        placer_(method, rays_, volume_) {}

  void cast(std::uint32_t tile) const {
    const std::uint32_t tile_side = kTileSide * rays_.pixel_stride;
    const std::uint32_t tiles_across = (rays_.width + tile_side - 1) / tile_side;
    const std::uint32_t left = tile % tiles_across * tile_side;
    const std::uint32_t top = tile / tiles_across * tile_side;
    const Segments segments(memory_.segment_masks + std::size_t{4} * tile, rays_.segment_shift);
    const bool is_empty_tile = method_.skips && segments.none();
    std::uint32_t sample_end = 0;
    std::uint32_t taken = 0;
    for (std::uint32_t row = 0; row < kTileSide; row += kBlockHeight) {
      for (std::uint32_t column = 0; column < kTileSide; column += kBlockWidth) {
        const Pixels pixels = pixels_at(left + column * rays_.pixel_stride, top + row * rays_.pixel_stride);
        if (pixels.in_picture == 0) continue;
        BlockResult result = {all(kNoSurface), all(1.0F), {zero(), zero(), zero()}};
        if (pixels.with_ray != 0 && !is_empty_tile) {
          const Block block = block_of(pixels);
          result = BlockCast(method_, memory_, volume_, placer_, segments, block).cast();
        } else if (pixels.with_ray != 0) {
          result.sample_end = static_cast<int>(rays_.steps);
        }
        sample_end = std::max(sample_end, static_cast<std::uint32_t>(result.sample_end));
        taken += result.taken;
        write(pixels, result);
      }
    }
    if (memory_.sample_ends == nullptr) return;
    std::uint32_t& end = memory_.sample_ends[tile];
    end = method_.counts ? end + taken : std::max(end, sample_end);
  }

 private:
  // The first pixel of each lane's ray. With a stride, a ray for several pixels goes through the first of
  // them in the viewport.
  struct Pixels {
    std::array<std::uint32_t, kMostLanes> column;
    std::array<std::uint32_t, kMostLanes> row;
    LaneFloats ray_column;
    LaneFloats ray_row;
    std::uint32_t in_picture = 0;  // bits of lanes
    std::uint32_t with_ray = 0;
  };

  // A pixel before the viewport wraps to a number beyond its size.
  bool in_viewport(std::uint32_t column, std::uint32_t row) const {
    return column - rays_.view_left < rays_.view_width && row - rays_.view_top < rays_.view_height;
  }

  Pixels pixels_at(std::uint32_t left, std::uint32_t top) const {
    const std::uint32_t stride = rays_.pixel_stride;
    Pixels pixels;
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t column = left + lane % kBlockWidth * stride;
      const std::uint32_t row = top + lane / kBlockWidth * stride;
      pixels.column[lane] = column;
      pixels.row[lane] = row;
      const std::uint32_t ray_column = stride > 1 ? std::max(column, rays_.view_left) : column;
      const std::uint32_t ray_row = stride > 1 ? std::max(row, rays_.view_top) : row;
      const bool in_picture = column < rays_.width && row < rays_.height;
      const bool has_ray = in_picture && ray_column < column + stride && ray_row < row + stride &&
                           in_viewport(ray_column, ray_row);
      pixels.ray_column.lane[lane] = static_cast<float>(ray_column);
      pixels.ray_row.lane[lane] = static_cast<float>(ray_row);
      pixels.in_picture |= static_cast<std::uint32_t>(in_picture) << lane;
      pixels.with_ray |= static_cast<std::uint32_t>(has_ray) << lane;
    }
    return pixels;
  }

  // ray_of() of ray.h.
  HWY_INLINE Rays rays_of(Floats column, Floats row) const {
    const auto plane =
        [&](const shaders::vec3& origin, const shaders::vec3& across, const shaders::vec3& down)
            HWY_ATTR { return at(at(all(origin), column, all(across)), row, all(down)); };
    const Point from = plane(rays_.origin, rays_.right_step, rays_.down_step);
    const Point forward = plane(rays_.forward, rays_.right_turn, rays_.down_turn);
    const Floats stride = hn::Sqrt(dot(forward, forward));  // mm of ray for each mm of depth
    const Point right = all(rays_.right);
    const Point aside = at(right, negative(dot(right, forward) / (stride * stride)), forward);
    const Floats step = all(rays_.step) / hn::Sqrt(dot(aside, aside));
    const Point across_right = {step * aside.x, step * aside.y, step * aside.z};
    const Point up = cross(across_right, forward);
    return {
        from, forward, all(rays_.step) / stride, across_right, {up.x / stride, up.y / stride, up.z / stride}};
  }

  Block block_of(const Pixels& pixels) const {
    Block block;
    const Floats column = loaded(pixels.ray_column);
    const Floats row = loaded(pixels.ray_row);
    block.rays = rays_of(column, row);
    const Floats start_mm = start_of_rays(*memory_.near_tissue, column, row);
    block.shown = volume_.cropped({hn::Max(all(rays_.start), start_mm), all(rays_.end)}, block.rays.from,
                                  block.rays.forward);
    set_samples(block);
    LaneFloats present = stored(zero());
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if ((pixels.with_ray >> lane & 1U) != 0) present.lane[lane] = 1.0F;
    }
    block.present = hn::Gt(loaded(present), zero());
    return block;
  }

  // scanned_interval() of cast.comp.
  HWY_INLINE Interval scanned_interval(const Rays& ray) const {
    Interval part = {all(std::max(rays_.start, rays_.eye)), all(rays_.end)};
    part = cut(part, ray.from.x - all(rays_.left), ray.forward.x);
    part = cut(part, all(rays_.right_side) - ray.from.x, negative(ray.forward.x));
    part = volume_.between_frames(part, ray.from, ray.forward);
    const Floats along = ray.from.y + all(rays_.motor_radius);
    const Floats a = ray.forward.y * ray.forward.y + ray.forward.z * ray.forward.z;
    const Floats half_b = along * ray.forward.y + ray.from.z * ray.forward.z;
    const Floats c = along * along + ray.from.z * ray.from.z - all(rays_.farthest * rays_.farthest);
    const Floats root = half_b * half_b - a * c;
    const Mask crosses = hn::Gt(a, all(1e-12F));
    const Floats reach = hn::Sqrt(hn::Max(root, zero()));
    const Mask misses = where(crosses, hn::Lt(root, zero()), hn::Gt(c, zero()));
    const Floats first = where(crosses, hn::Max(part.first, (negative(half_b) - reach) / a), part.first);
    const Floats last = where(crosses, hn::Min(part.last, (reach - half_b) / a), part.last);
    return {where(misses, all(1.0F), first), where(misses, zero(), last)};
  }

  // samples_of_ray() of cast.comp.
  HWY_INLINE void set_samples(Block& block) const {
    Interval part = scanned_interval(block.rays);
    const Floats beyond_crop = all(2.0F * static_cast<float>(method_.window)) * block.rays.spacing;
    part.first = hn::Max(part.first, block.shown.first - beyond_crop);
    part.last = hn::Min(part.last, block.shown.last + beyond_crop);
    const Mask hidden = hn::Gt(block.shown.first, block.shown.last);
    part = {where(hidden, all(1.0F), part.first), where(hidden, zero(), part.last)};
    const Floats most = all(static_cast<float>(rays_.steps));
    const Floats start = all(rays_.start);
    block.first = clamped(hn::Ceil((part.first - start) / block.rays.spacing), zero(), most);
    const Floats end = clamped(hn::Floor((part.last - start) / block.rays.spacing) + all(1.0F), zero(), most);
    block.end = where(hn::Gt(part.first, part.last), zero(), end);
  }

  // As packUnorm4x8, with alpha_of() of certainty.h.
  struct PackedColours {
    alignas(sizeof(std::uint32_t) * kMostLanes) std::uint32_t lane[kMostLanes];
  };
  HWY_INLINE static Words unorm8(Floats value) {
    return hn::BitCast(kWords, hn::NearestInt(clamped(value, zero(), all(1.0F)) * all(255.0F)));
  }
  HWY_INLINE static PackedColours packed(const BlockResult& result) {
    constexpr float kCertaintySteps = 254.0F;
    const Floats certain = (all(1.0F) + all(kCertaintySteps) * result.certainty) / all(255.0F);
    const Floats alpha = hn::IfThenElseZero(hn::Ge(result.surface, zero()), certain);
    const Words red_green = hn::Or(unorm8(result.colour.red), hn::ShiftLeft<8>(unorm8(result.colour.green)));
    const Words blue_alpha =
        hn::Or(hn::ShiftLeft<16>(unorm8(result.colour.blue)), hn::ShiftLeft<24>(unorm8(alpha)));
    PackedColours colours;
    hn::Store(hn::Or(red_green, blue_alpha), kWords, colours.lane);
    return colours;
  }

  // Writes the results to all pixels of the rays that lie in the picture.
  void write(const Pixels& pixels, const BlockResult& result) const {
    const LaneFloats surface = stored(result.surface);
    const PackedColours colours = packed(result);
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t end_column = std::min(pixels.column[lane] + rays_.pixel_stride, rays_.width);
      const std::uint32_t end_row = std::min(pixels.row[lane] + rays_.pixel_stride, rays_.height);
      for (std::uint32_t row = pixels.row[lane]; row < end_row; ++row) {
        for (std::uint32_t column = pixels.column[lane]; column < end_column; ++column) {
          const bool shown = in_viewport(column, row);
          const std::size_t index = std::size_t{row} * rays_.width + column;
          const float depth = shown ? surface.lane[lane] : kNoSurface;
          memory_.depth[index] = depth;
          memory_.ray_depth[index] = depth;
          memory_.volume_colour[index] = shown ? colours.lane[lane] : 0xFF000000U;
        }
      }
    }
  }

  const Method& method_;
  const Memory& memory_;
  const shaders::CastParameters& rays_;
  FanVolume volume_;
  SurfacePlacer placer_;
};

void cast_tiles(const Method& method, const Memory& memory, std::uint32_t first, std::uint32_t end,
                const std::uint32_t* tile_list) {
  const TileCast caster(method, memory);
  for (std::uint32_t number = first; number < end; ++number)
    caster.cast(tile_list != nullptr ? tile_list[number] : number);
}

}  // namespace fanlight::ray_caster::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fanlight::ray_caster {

namespace {

HWY_EXPORT(cast_tiles);

}  // namespace

bool is_fast() {
  return (hwy::SupportedTargets() & HWY_TARGETS & (HWY_AVX2 | HWY_AVX3 | HWY_AVX3_DL)) != 0;
}

void cast_tiles(const Method& method, const Memory& memory, std::uint32_t first, std::uint32_t end,
                const std::uint32_t* tile_list) {
  HWY_DYNAMIC_DISPATCH(cast_tiles)(method, memory, first, end, tile_list);
}

}  // namespace fanlight::ray_caster
#endif
