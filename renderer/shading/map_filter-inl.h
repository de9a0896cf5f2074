// SPDX-License-Identifier: Apache-2.0
// The filter of the depth map, pass 2: temporal.comp for a volume alone, tile_depth_range.comp,
// cleanup_tiles.comp, islands.comp, holes.comp and map_totals.comp for a vector of
// pixels. See shaders/ for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_SHADING_MAP_FILTER) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_MAP_FILTER
#undef FANLIGHT_RENDERER_SHADING_MAP_FILTER
#else
#define FANLIGHT_RENDERER_SHADING_MAP_FILTER
#endif

#include <bit>

#include "renderer/shading/surface_map-inl.h"
#include "renderer/shading/surface_shading.hpp"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

constexpr int kTileSide = 8;
// A pixel with fewer shows one volume.
constexpr float kLeastVolumes = 1.3F;

// Whether tiles are marked, for each pixel of a run. Beyond the picture none is.
HWY_INLINE Mask tile_is_marked(const Memory& memory, int column, int row) {
  const int width = static_cast<int>(memory.lighting->width);
  const int tiles_across = (width + kTileSide - 1) / kTileSide;
  const std::uint32_t* const tiles = memory.cleanup_tiles + static_cast<std::size_t>(row / kTileSide) *
                                                                static_cast<std::size_t>(tiles_across);
  LaneFloats lanes;
  for (int lane = 0; lane < kRun; ++lane)
    lanes.lane[lane] = column + lane < width && tiles[(column + lane) / kTileSide] != 0 ? 1.0F : 0.0F;
  return hn::Gt(loaded(lanes), zero());
}

class MapFilter {
 public:
  explicit MapFilter(const Memory& memory)
      : memory_(memory),
        lighting_(*memory.lighting),
        width_(static_cast<int>(memory.lighting->width)),
        height_(static_cast<int>(memory.lighting->height)) {}

  // Depths and volumes of a volume alone.
  void take(int column, int row, int count) const {
    const Floats depth = read_row(memory_.volume_depth + start_of(row), column, 0, width_ - 1);
    const Floats volumes = hn::IfThenElseZero(hn::Ge(depth, zero()), all(1.0F));
    write_pairs({words_of(depth), words_of(volumes)}, memory_.steady + 2 * (start_of(row) + offset(column)),
                count);
  }

  // The range of depths in each tile of a row of tiles.
  void find_tile_depths(int tile_row) const {
    float* const ranges = memory_.tile_depths + 2 * static_cast<std::size_t>(tile_row) * tiles_across();
    for (std::size_t tile = 0; tile < tiles_across(); ++tile) {
      float smallest = kMostDepth;
      float largest = kNoSurface;
      const int first_column = kTileSide * static_cast<int>(tile);
      for (int down = 0; down < kTileSide; ++down) {
        const int row = std::min(kTileSide * tile_row + down, height_ - 1);
        for (int across = 0; across < kTileSide; ++across) {
          const int column = std::min(first_column + across, width_ - 1);
          const auto depth = std::bit_cast<float>(memory_.steady[2 * (start_of(row) + offset(column))]);
          smallest = std::min(smallest, depth);
          largest = std::max(largest, depth);
        }
      }
      ranges[2 * tile] = smallest;
      ranges[2 * tile + 1] = largest;
    }
  }

  // Marks the tiles of a row of tiles where islands, holes or outlines may be.
  void mark_tiles(int tile_row) const {
    const int radius = std::max(lighting_.islands_radius, lighting_.holes_radius);
    const int reach = std::max((radius + kTileSide - 1) / kTileSide, 1);
    const int across = static_cast<int>(tiles_across());
    const int down = (height_ + kTileSide - 1) / kTileSide;
    for (int tile = 0; tile < across; ++tile) {
      float smallest = kMostDepth;
      float largest = kNoSurface;
      for (int y = std::max(tile_row - reach, 0); y <= std::min(tile_row + reach, down - 1); ++y) {
        for (int x = std::max(tile - reach, 0); x <= std::min(tile + reach, across - 1); ++x) {
          const float* const range = memory_.tile_depths + 2 * (offset(y) * tiles_across() + offset(x));
          smallest = std::min(smallest, range[0]);
          largest = std::max(largest, range[1]);
        }
      }
      const bool one_surface = smallest >= 0 && largest - smallest <= lighting_.same_surface;
      const bool is_even = one_surface || largest < 0;
      memory_.cleanup_tiles[offset(tile_row) * tiles_across() + offset(tile)] = is_even ? 0 : 1;
    }
  }

  // Removes islands.
  void clean(int column, int row, int count) const {
    const Floats here = steady_from(column, row);
    Floats cleaned = here;
    const Mask due = hn::And(hn::Ge(here, zero()), tile_is_marked(memory_, column, row));
    if (!is_empty(due)) {
      const int radius = lighting_.islands_radius;
      Floats on_surface = zero();
      for (int y = std::max(row - radius, lighting_.view_top);
           y <= std::min(row + radius, lighting_.view_bottom); ++y) {
        for (int across = -radius; across <= radius; ++across) {
          const Mask same = same_surface(here, steady_from(column + across, y));
          const Mask counts = hn::And(same, column_in_view(column + across));
          on_surface = on_surface + hn::IfThenElseZero(counts, all(1.0F));
        }
      }
      const Mask is_island = hn::Lt(all(4.0F) * on_surface, window_pixels(column, row, radius));
      cleaned = where(hn::And(due, is_island), all(kNoSurface), here);
    }
    write_row(words_of(cleaned), words_at(memory_.smooth_depth, column, row), count);
  }

  // Fills holes, and sets the weights.
  void fill(int column, int row, int count) const {
    const Floats here = read_row(memory_.smooth_depth + start_of(row), column, 0, width_ - 1);
    const Mask known = hn::Ge(here, zero());
    Words weight = hn::Set(kWords, 1U);
    if (lighting_.confidence_counts != 0) {
      const Floats confidence = read_row(memory_.confidence + start_of(row), column, 0, width_ - 1);
      const Floats rounded = hn::Floor(all(4.0F) * confidence + all(0.5F));
      const Floats bounded = clamped(rounded, all(1.0F), all(static_cast<float>(FANLIGHT_MAX_WEIGHT)));
      weight = hn::BitCast(kWords, whole(where(known, bounded, all(1.0F))));
    }
    Floats filled = here;
    if (lighting_.holes_radius > 0 && row >= lighting_.view_top && row <= lighting_.view_bottom) {
      const Mask outside = hn::Not(column_in_view(column));
      const Mask is_hole = hn::AndNot(hn::Or(known, outside), tile_is_marked(memory_, column, row));
      if (!is_empty(is_hole)) filled = where(is_hole, filled_depth(column, row), here);
    }
    const auto present = mask_of_words(hn::Ge(filled, zero()));
    write_row(words_of(filled), words_at(memory_.filled, column, row), count);
    write_row(hn::IfThenElseZero(present, weight), memory_.weights + start_of(row) + offset(column), count);
  }

  // Of the whole map.
  shaders::MapTotals totals() const {
    Floats smallest = all(kMostDepth);
    std::uint32_t surface_pixels = 0;
    std::uint32_t uncertain_pixels = 0;
    std::uint32_t steady_pixels = 0;
    std::uint32_t volumes = 0;
    for (int row = 0; row < height_; ++row) {
      for (int column = 0; column < width_; column += kRun) {
        const Floats depth = read_row(memory_.smooth_depth + start_of(row), column, 0, width_ - 1);
        const Mask in_row =
            hn::Lt(hn::Iota(kFloats, static_cast<float>(column)), all(static_cast<float>(width_)));
        const Mask present = hn::And(in_row, hn::Ge(depth, zero()));
        smallest = hn::Min(smallest, where(present, depth, all(kMostDepth)));
        const Words alpha =
            hn::ShiftRight<24>(read_row(memory_.volume_colour + start_of(row), column, 0, width_ - 1));
        const Mask certain = hn::Ge(small_number_of(alpha), all(255.0F));
        const Floats averaged =
            floats_of(read_pairs(memory_.steady + 2 * start_of(row), column, 0, width_ - 1).second);
        const Mask steady = hn::And(present, hn::Ge(averaged, all(kLeastVolumes)));
        surface_pixels += static_cast<std::uint32_t>(hn::CountTrue(kFloats, present));
        uncertain_pixels += static_cast<std::uint32_t>(hn::CountTrue(kFloats, hn::AndNot(certain, present)));
        if (is_empty(steady)) continue;
        steady_pixels += static_cast<std::uint32_t>(hn::CountTrue(kFloats, steady));
        const Floats units = hn::Floor(averaged * all(static_cast<float>(FANLIGHT_VOLUME_UNITS)) + all(0.5F));
        volumes += static_cast<std::uint32_t>(sum_of(hn::IfThenElseZero(steady, units)));
      }
    }
    const LaneFloats lanes = stored(smallest);
    return {.min_depth = std::bit_cast<std::uint32_t>(*std::min_element(lanes.lane, lanes.lane + kRun)),
            .surface_pixels = surface_pixels,
            .uncertain_pixels = uncertain_pixels,
            .steady_pixels = steady_pixels,
            .volumes = volumes};
  }

 private:
  static std::size_t offset(int index) { return static_cast<std::size_t>(index); }
  std::size_t start_of(int row) const { return offset(row) * offset(width_); }
  std::size_t tiles_across() const { return offset((width_ + kTileSide - 1) / kTileSide); }
  std::uint32_t* words_at(float* map, int column, int row) const {
    return reinterpret_cast<std::uint32_t*>(map + start_of(row) + offset(column));
  }
  static hn::Mask<decltype(kWords)> mask_of_words(Mask mask) {
    return hn::MaskFromVec(hn::BitCast(kWords, hn::VecFromMask(kFloats, mask)));
  }
  static float sum_of(Floats values) {
    const LaneFloats lanes = stored(values);
    float sum = 0;
    for (int lane = 0; lane < kRun; ++lane) sum += lanes.lane[lane];
    return sum;
  }

  Floats steady_from(int column, int row) const {
    return floats_of(read_pairs(memory_.steady + 2 * start_of(row), column, 0, width_ - 1).first);
  }
  Mask column_in_view(int column) const {
    return lies_within(hn::Iota(kFloats, static_cast<float>(column)), lighting_.view_left,
                       lighting_.view_right);
  }
  Mask same_surface(Floats a, Floats b) const {
    const Mask both = hn::And(hn::Ge(a, zero()), hn::Ge(b, zero()));
    return hn::And(both, hn::Le(hn::Abs(a - b), all(lighting_.same_surface)));
  }

  // Pixels of the window about each pixel of a run, clipped to the viewport.
  Floats window_pixels(int column, int row, int radius) const {
    const int down =
        std::min(row + radius, lighting_.view_bottom) - std::max(row - radius, lighting_.view_top) + 1;
    const Floats x = hn::Iota(kFloats, static_cast<float>(column));
    const Floats reach = all(static_cast<float>(radius));
    const Floats last = hn::Min(x + reach, all(static_cast<float>(lighting_.view_right)));
    const Floats first = hn::Max(x - reach, all(static_cast<float>(lighting_.view_left)));
    return (last - first + all(1.0F)) * all(static_cast<float>(down));
  }

  // The depth that fills a hole at each pixel of a run, or FANLIGHT_NO_SURFACE.
  Floats filled_depth(int column, int row) const {
    const int radius = lighting_.holes_radius;
    const int top = std::max(row - radius, lighting_.view_top);
    const int bottom = std::min(row + radius, lighting_.view_bottom);
    Floats surfaces = zero();
    Floats nearest = all(1e9F);
    Floats reference = all(kNoSurface);
    for (int y = top; y <= bottom; ++y) {
      for (int across = -radius; across <= radius; ++across) {
        const Floats there = cleaned_from(column + across, y);
        const Mask present = hn::Ge(there, zero());
        const Floats square = all(static_cast<float>(across * across + (y - row) * (y - row)));
        const Mask nearer = hn::And(present, hn::Lt(square, nearest));
        surfaces = surfaces + hn::IfThenElseZero(present, all(1.0F));
        nearest = where(nearer, square, nearest);
        reference = where(nearer, there, reference);
      }
    }
    const Mask fills = hn::Ge(all(2.0F) * surfaces, window_pixels(column, row, radius));
    if (is_empty(fills)) return all(kNoSurface);
    Floats sum = zero();
    Floats weights = zero();
    for (int y = top; y <= bottom; ++y) {
      for (int across = -radius; across <= radius; ++across) {
        const Floats there = cleaned_from(column + across, y);
        const int square = across * across + (y - row) * (y - row);
        const Floats share = all(1.0F / static_cast<float>(std::max(square, 1)));
        const Floats weight = hn::IfThenElseZero(same_surface(there, reference), share);
        sum = sum + weight * (there - reference);
        weights = weights + weight;
      }
    }
    return where(fills, reference + sum / hn::Max(weights, all(1e-6F)), all(kNoSurface));
  }

  // The map without islands; FANLIGHT_NO_SURFACE beside the viewport.
  Floats cleaned_from(int column, int row) const {
    const Floats depth = read_row(memory_.smooth_depth + start_of(row), column, 0, width_ - 1);
    return where(column_in_view(column), depth, all(kNoSurface));
  }

  const Memory& memory_;
  const shaders::LightParameters& lighting_;
  int width_;
  int height_;
};

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
