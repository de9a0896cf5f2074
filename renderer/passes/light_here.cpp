// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/light_here.hpp"

#include <algorithm>
#include <cstring>

#include "proto/base/clock.hpp"
#include "renderer/passes/pixel_rect.hpp"
#include "shaders/map_totals.h"

namespace fanlight {

namespace {

std::uint32_t* words_of(const GpuBuffer& buffer) {
  return &buffer.mapped_as<std::uint32_t>();
}

float* floats_of(const GpuBuffer& buffer) {
  return &buffer.mapped_as<float>();
}

/// The regions are whole tiles, which may reach beyond the picture.
LightStep here(shading::Step step, const PixelRect& part, const PixelRect& whole) {
  return {.here = step,
          .part = {.left = part.left,
                   .top = part.top,
                   .right = std::min(part.right, whole.right),
                   .bottom = std::min(part.bottom, whole.bottom)}};
}

// Rows or columns that one thread computes at a time.
constexpr int kStrip = kTileSide;  // some steps compute whole rows of tiles
constexpr int kColumns = 64;

/// A part of what a step computes, for one thread. They are numbered from 0 on.
shading::Part strip_of(const LightStep& step, int number) {
  const PixelRect& part = step.part;
  switch (*step.here) {
    case shading::Step::kTotals:
      return {part.left, part.top, part.right, part.bottom};
    case shading::Step::kMeanColumns: {
      const int left = part.left + kColumns * number;
      return {left, part.top, std::min(left + kColumns, part.right), part.bottom};
    }
    default: {
      const int top = part.top + kStrip * number;
      return {part.left, top, part.right, std::min(top + kStrip, part.bottom)};
    }
  }
}

std::size_t strips_of(const LightStep& step) {
  const auto pieces = [](int length, int piece) {
    return static_cast<std::size_t>((std::max(length, 0) + piece - 1) / piece);
  };
  switch (*step.here) {
    case shading::Step::kTotals:
      return 1;
    case shading::Step::kMeanColumns:
      return pieces(step.part.right - step.part.left, kColumns);
    default:
      return pieces(step.part.bottom - step.part.top, kStrip);
  }
}

}  // namespace

void LightHere::begin(const LightKeys& keys) {
  spans_ = {};
  ms_ = {};
  change(keys);
}

void LightHere::change(const LightKeys& keys) {
  // The soft light takes its shadows, and the light takes them from there.
  const PipelineKey& shadows = keys.soft_light ? *keys.soft_light : keys.light;
  method_ = {.perspective = shadows.constants[0] != 0,
             .soft_shadows = shadows.constants[1] != 0,
             .soft_light = keys.soft_light.has_value(),
             .keeps_edges = keys.filter_rows.shader == Shader::kSmooth && keys.filter_rows.constants[1] != 0};
}

void LightHere::read(const CastMaps& maps) {
  depth_ = floats_of(maps.depth);
  confidence_ = floats_of(maps.confidence);
  colour_ = words_of(maps.colour);
}

void LightHere::add_step(LightSteps& steps, shading::Step step, const PixelRect& part, PictureSize size) {
  steps.add(here(step, part, PixelRect::whole(size)));
}

void LightHere::add_filter_steps(LightSteps& steps, const LightKeys& keys, const LightRegions& parts,
                                 PictureSize size) {
  using shading::Step;
  const bool mean = keys.filter_rows.shader == Shader::kMeanRows;
  const PixelRect all = PixelRect::whole(size);
  const auto rows_of = [&all](const PixelRect& part) {
    return PixelRect{.left = all.left, .top = part.top, .right = all.right, .bottom = part.bottom};
  };
  add_step(steps, Step::kTileDepths, rows_of(parts.changed), size);
  add_step(steps, Step::kCleanupTiles, rows_of(parts.uneven), size);
  add_step(steps, Step::kIslands, parts.cleaned, size);
  add_step(steps, Step::kHoles, parts.filled, size);
  add_step(steps, mean ? Step::kMeanRows : Step::kSmoothRows, parts.rows, size);
  add_step(steps, mean ? Step::kMeanColumns : Step::kSmoothColumns, parts.smooth, size);
  add_step(steps, Step::kTotals, all, size);
}

void LightHere::add_light_steps(LightSteps& steps, const LightKeys& keys, const LightRegions& parts,
                                const LightOptions& options) {
  using shading::Step;
  const PixelRect all = PixelRect::whole(options.size);
  const PixelRect places = {.right = (all.right + 1) / 2, .bottom = (all.bottom + 1) / 2};
  const auto add = [&steps](Step step, const PixelRect& part, const PixelRect& whole, Stage stage) {
    LightStep added = here(step, part, whole);
    added.stage = stage;
    steps.add(added);
  };
  if (keys.soft_light) add(Step::kSoftLight, places, places, Stage::kLight);
  if (keys.scatter_rows) add(Step::kScatterRows, places, places, Stage::kLight);
  if (keys.scatter_columns) add(Step::kScatterColumns, places, places, Stage::kLight);
  add(Step::kLight, parts.lit, all, Stage::kLight);
  int done = 0;
  const auto add_finish = [&](Step step, const PixelRect& part) {
    LightStep added = here(step, part, all);
    added.stage = Stage::kFinish;
    added.order = LightSteps::order_after(done++);
    steps.add(added);
  };
  if (options.outlines) add_finish(Step::kOutline, parts.outlined);
  for (int step = 0; step < options.diffusion_steps; ++step) add_finish(Step::kDiffuse, parts.finished);
  add_finish(Step::kFinish, parts.finished);
}

shading::Memory LightHere::memory_of(const LightStep& step, const LightMemory& memory) const {
  const bool reads_lit = step.order == DescriptorSets::Order::kLitToDiffused;
  std::uint32_t* const lit = words_of(memory.row_sums);
  std::uint32_t* const diffused = words_of(memory.diffused);
  return {.lighting = &memory.parameters.mapped_as<shaders::LightParameters>(),
          .volume_depth = depth_,
          .confidence = confidence_,
          .volume_colour = colour_,
          .steady = words_of(memory.steady),
          .tile_depths = floats_of(memory.tile_depths),
          .cleanup_tiles = words_of(memory.uneven),
          .filled = floats_of(memory.filled),
          .weights = words_of(memory.weights),
          .row_sums = words_of(memory.row_sums),
          .smooth_depth = floats_of(memory.smooth_depth),
          .totals = &memory.map_totals.mapped_as<shaders::MapTotals>(),
          .soft_lights = diffused,
          .from = reads_lit ? lit : diffused,
          .to = step.here == shading::Step::kLight || !reads_lit ? lit : diffused,
          .finished = words_of(memory.read_back)};
}

void LightHere::run(const LightSteps& steps, std::size_t begin, std::size_t end, const LightMemory& memory) {
  for (std::size_t index = begin; index < end; ++index) {
    const LightStep& step = steps[index];
    const std::int64_t began_ns = now_ns();
    const shading::Memory of_step = memory_of(step, memory);
    workers_->run(strips_of(step), [&](std::size_t, std::size_t strip) {
      shading::run(*step.here, method_, of_step, strip_of(step, static_cast<int>(strip)));
    });
    note(step.stage, began_ns);
  }
}

void LightHere::read_back(const LightMemory& memory, PictureSize size, bool colours) {
  const std::int64_t began_ns = now_ns();
  const std::size_t bytes = size.pixels() * sizeof(std::uint32_t);
  std::memcpy(words_of(memory.read_back_depth), words_of(memory.smooth_depth), bytes);
  if (colours) std::memcpy(words_of(memory.read_back_colours), colour_, bytes);
  memory.read_back_totals.mapped_as<shaders::MapTotals>() = memory.map_totals.mapped_as<shaders::MapTotals>();
  note(Stage::kReadBack, began_ns);
}

void LightHere::note(Stage stage, std::int64_t began_ns) {
  const auto index = static_cast<std::size_t>(stage);
  StageSpan& span = spans_[index];
  if (span.begin_ns == 0) span.begin_ns = began_ns;
  span.end_ns = now_ns();
  ms_[index] += StageSpan{.begin_ns = began_ns, .end_ns = span.end_ns}.ms();
}

}  // namespace fanlight
