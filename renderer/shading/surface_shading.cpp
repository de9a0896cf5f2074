// SPDX-License-Identifier: Apache-2.0
#include "renderer/shading/surface_shading.hpp"

#include <algorithm>
#include <bit>

#include "shaders/bindings.h"

// Highway includes this file once for each instruction set, without those that ray_caster.cpp leaves out.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SSE4 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/shading/surface_shading.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "renderer/shading/finish-inl.h"
#include "renderer/shading/map_filter-inl.h"
#include "renderer/shading/map_smoothing-inl.h"
#include "renderer/shading/shade-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

SurfaceMap map_of(const Method& method, const Memory& memory) {
  return {*memory.lighting, method.perspective, method.soft_shadows, memory.smooth_depth,
          std::bit_cast<float>(memory.totals->min_depth)};
}

// What one step of the filter does with a run of pixels.
using FilterRun = void (MapFilter::*)(int column, int row, int count) const;

void filter_runs(const Memory& memory, const Part& part, FilterRun run) {
  const MapFilter filter(memory);
  for (int row = part.top; row < part.bottom; ++row) {
    for (int column = part.left; column < part.right; column += kRun)
      (filter.*run)(column, row, part.right - column);
  }
}

void filter_tiles(const Memory& memory, const Part& part, bool marks) {
  const MapFilter filter(memory);
  for (int tile_row = part.top / kTileSide; tile_row < (part.bottom + kTileSide - 1) / kTileSide;
       ++tile_row) {
    if (marks) {
      filter.mark_tiles(tile_row);
    } else {
      filter.find_tile_depths(tile_row);
    }
  }
}

void smooth(const Method& method, const Memory& memory, const Part& part, bool columns) {
  const MapSmoothing smoothing(memory);
  const Shares shares(memory.lighting->filter_fall, memory.lighting->filter_radius);
  for (int row = part.top; row < part.bottom; ++row) {
    for (int column = part.left; column < part.right; column += kRun)
      smoothing.smooth(column, row, part.right - column, columns, method.keeps_edges, shares);
  }
}

void average(const Memory& memory, const Part& part, bool columns) {
  const MapSmoothing smoothing(memory);
  for (int row = part.top; row < part.bottom && !columns; ++row) smoothing.sum_row(row);
  for (int column = part.left; column < part.right && columns; column += kRun)
    smoothing.average_columns(column, part.right - column);
}

void light_softly(const Method& method, const Memory& memory, const Part& part) {
  const SurfaceMap map = map_of(method, memory);
  const SoftSurface surface(map);
  const SoftMaps maps(*memory.lighting, memory.soft_lights);
  for (int row = part.top; row < part.bottom; ++row) {
    for (int column = part.left; column < part.right; column += kRun) {
      Four direct;
      Four scattered;
      surface.light(column, row, direct, scattered);
      maps.write(direct, column, row, 0);
      maps.write(scattered, column, row, 1);
    }
  }
}

void scatter(const Method& method, const Memory& memory, const Part& part, bool columns) {
  const SurfaceMap map = map_of(method, memory);
  const SoftMaps maps(*memory.lighting, memory.soft_lights);
  const int from = columns ? 2 : 1;
  for (int row = part.top; row < part.bottom; ++row) {
    for (int column = part.left; column < part.right; column += kRun)
      maps.write(scattered_light(map, maps, column, row, from, columns), column, row, 3 - from);
  }
}

void light(const Method& method, const Memory& memory, const Part& part) {
  const SurfaceMap map = map_of(method, memory);
  const SoftMaps maps(*memory.lighting, memory.soft_lights);
  const Shade shade(map, method.soft_light ? &maps : nullptr, memory.volume_colour);
  const LitPicture lit(*memory.lighting, memory.to);
  for (int row = part.top; row < part.bottom; ++row) {
    for (int column = part.left; column < part.right; column += kRun)
      lit.write(shade.shown(column, row), column, row, part.right - column);
  }
}

void outline(const Method& method, const Memory& memory, const Part& part) {
  const SurfaceMap map = map_of(method, memory);
  const LitPicture lit(*memory.lighting, memory.from);
  const LitPicture to(*memory.lighting, memory.to);
  const Outline outline(map, lit);
  for (int row = part.top; row < part.bottom; ++row) {
    for (int column = part.left; column < part.right; column += kRun) {
      const bool in_rows = map.has_view() && map.row_in_view(row);
      Mask wanted = none();
      if (in_rows)
        wanted = hn::And(tile_is_marked(memory, column, row), map.in_view(pixels_from(column, row)));
      const WordPairs words =
          is_empty(wanted) ? lit.words_from(column, row) : outline.outlined(column, row, wanted);
      to.write(words, column, row, part.right - column);
    }
  }
}

void diffuse(const Memory& memory, const Part& part) {
  const LitPicture lit(*memory.lighting, memory.from);
  const LitPicture to(*memory.lighting, memory.to);
  for (int row = part.top; row < part.bottom; ++row) {
    for (int column = part.left; column < part.right; column += kRun)
      to.write(diffused_colour(lit, column, row, memory.lighting->diffusion_scale), column, row,
               part.right - column);
  }
}

void finish(const Memory& memory, const Part& part) {
  const LitPicture lit(*memory.lighting, memory.from);
  for (int row = part.top; row < part.bottom; ++row) {
    std::uint32_t* const to = memory.finished + static_cast<std::size_t>(row) * memory.lighting->width;
    for (int column = part.left; column < part.right; column += kRun)
      write_row(finished_pixels(*memory.lighting, lit, column, row), to + column, part.right - column);
  }
}

void run(Step step, const Method& method, const Memory& memory, const Part& part) {
  switch (step) {
    case Step::kTake:
      return filter_runs(memory, part, &MapFilter::take);
    case Step::kTileDepths:
      return filter_tiles(memory, part, false);
    case Step::kCleanupTiles:
      return filter_tiles(memory, part, true);
    case Step::kIslands:
      return filter_runs(memory, part, &MapFilter::clean);
    case Step::kHoles:
      return filter_runs(memory, part, &MapFilter::fill);
    case Step::kMeanRows:
      return average(memory, part, false);
    case Step::kMeanColumns:
      return average(memory, part, true);
    case Step::kSmoothRows:
      return smooth(method, memory, part, false);
    case Step::kSmoothColumns:
      return smooth(method, memory, part, true);
    case Step::kTotals:
      *memory.totals = MapFilter(memory).totals();
      return;
    case Step::kSoftLight:
      return light_softly(method, memory, part);
    case Step::kScatterRows:
      return scatter(method, memory, part, false);
    case Step::kScatterColumns:
      return scatter(method, memory, part, true);
    case Step::kLight:
      return light(method, memory, part);
    case Step::kOutline:
      return outline(method, memory, part);
    case Step::kDiffuse:
      return diffuse(memory, part);
    case Step::kFinish:
      return finish(memory, part);
  }
}

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fanlight::shading {

namespace {

HWY_EXPORT(run);

}  // namespace

void run(Step step, const Method& method, const Memory& memory, const Part& part) {
  HWY_DYNAMIC_DISPATCH(run)(step, method, memory, part);
}

}  // namespace fanlight::shading
#endif
