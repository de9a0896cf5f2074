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

/// What a step computes. Those of the soft light have one place for each 2 x 2 pixels.
shading::Part part_of(const LightStep& step, PictureSize size) {
  const bool by_places = *step.here <= shading::Step::kScatterColumns;
  const auto side = static_cast<std::uint32_t>(kTileSide);
  const std::uint32_t width = by_places ? (size.width + 1) / 2 : size.width;
  const std::uint32_t height = by_places ? (size.height + 1) / 2 : size.height;
  return {.left = static_cast<int>(side * step.first_across),
          .top = static_cast<int>(side * step.first_down),
          .right = static_cast<int>(std::min(side * (step.first_across + step.groups_across), width)),
          .bottom = static_cast<int>(std::min(side * (step.first_down + step.groups_down), height))};
}

shading::Memory memory_of(const LightStep& step, const LightMemory& memory, const std::uint32_t* colours) {
  const bool reads_lit = step.order == DescriptorSets::Order::kLitToDiffused;
  std::uint32_t* const lit = words_of(memory.row_sums);
  std::uint32_t* const diffused = words_of(memory.diffused);
  return {.lighting = &memory.parameters.mapped_as<shaders::LightParameters>(),
          .totals = &memory.map_totals.mapped_as<shaders::MapTotals>(),
          .smooth_depth = &memory.smooth_depth.mapped_as<float>(),
          .volume_colour = colours,
          .cleanup_tiles = words_of(memory.uneven),
          .soft_lights = diffused,
          .from = reads_lit ? lit : diffused,
          .to = step.here == shading::Step::kLight || !reads_lit ? lit : diffused,
          .finished = words_of(memory.read_back)};
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
             .soft_light = keys.soft_light.has_value()};
}

void LightHere::run(const LightSteps& steps, std::size_t begin, std::size_t end, const LightMemory& memory,
                    const std::uint32_t* colours, PictureSize size) {
  for (std::size_t index = begin; index < end; ++index) {
    const LightStep& step = steps[index];
    const std::int64_t began_ns = now_ns();
    const shading::Part part = part_of(step, size);
    const shading::Memory maps = memory_of(step, memory, colours);
    workers_->run(step.groups_down, [&](std::size_t, std::size_t strip) {
      const int top = part.top + kTileSide * static_cast<int>(strip);
      shading::run(*step.here, method_, maps,
                   {.left = part.left,
                    .top = top,
                    .right = part.right,
                    .bottom = std::min(top + kTileSide, part.bottom)});
    });
    note(step.stage, began_ns);
  }
}

void LightHere::read_back(const LightMemory& memory, const std::uint32_t* colours, PictureSize size) {
  const std::int64_t began_ns = now_ns();
  const std::size_t bytes = size.pixels() * sizeof(std::uint32_t);
  std::memcpy(words_of(memory.read_back_depth), words_of(memory.smooth_depth), bytes);
  if (colours != nullptr) std::memcpy(words_of(memory.read_back_colours), colours, bytes);
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
