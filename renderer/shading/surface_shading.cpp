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
#include "renderer/shading/shade-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

constexpr int kTileSide = 8;

SurfaceMap map_of(const Method& method, const Memory& memory) {
  return {*memory.lighting, method.perspective, method.soft_shadows, memory.smooth_depth,
          std::bit_cast<float>(memory.totals->min_depth)};
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

// The pixels of a run whose tiles may have an outline.
HWY_INLINE Mask may_have_outline(const Memory& memory, int column, int row) {
  const int width = static_cast<int>(memory.lighting->width);
  const int tiles_across = (width + kTileSide - 1) / kTileSide;
  const std::uint32_t* const tiles = memory.cleanup_tiles + static_cast<std::size_t>(row / kTileSide) *
                                                                static_cast<std::size_t>(tiles_across);
  LaneFloats lanes;
  for (int lane = 0; lane < kRun; ++lane)
    lanes.lane[lane] = column + lane < width && tiles[(column + lane) / kTileSide] != 0 ? 1.0F : 0.0F;
  return hn::Gt(loaded(lanes), zero());
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
        wanted = hn::And(may_have_outline(memory, column, row), map.in_view(pixels_from(column, row)));
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

bool is_fast() {
  return (hwy::SupportedTargets() & HWY_TARGETS & (HWY_AVX2 | HWY_AVX3 | HWY_AVX3_DL)) != 0;
}

void run(Step step, const Method& method, const Memory& memory, const Part& part) {
  HWY_DYNAMIC_DISPATCH(run)(step, method, memory, part);
}

}  // namespace fanlight::shading
#endif
