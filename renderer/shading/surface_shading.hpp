// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "shaders/light_parameters.h"
#include "shaders/map_totals.h"

/// Passes 2 and 3 on a processor: the same pictures as temporal.comp to finish.comp (shaders/passes.inc),
/// which GPUs run, and processors whose rays a shader casts. The temporal filter of several volumes, and the
/// seam of a rolling sweep, are the shaders' everywhere. Compiled for several instruction sets by Highway; a
/// vector of neighbouring pixels is lit at a time (decision renderer/018).
///
/// Most pixels are the shaders'; others differ by one level of 255, where a value lies between two.
/// Instruction sets that multiply and add at once (AVX2, AVX-512, NEON) give the same picture.
namespace fanlight::shading {

/// In the order in which they run.
enum class Step : std::uint8_t {
  kTake,            ///< temporal.comp for a volume alone
  kTileDepths,      ///< tile_depth_range.comp
  kCleanupTiles,    ///< cleanup_tiles.comp
  kIslands,         ///< islands.comp
  kHoles,           ///< holes.comp
  kMeanRows,        ///< mean_rows.comp
  kMeanColumns,     ///< mean_columns.comp
  kSmoothRows,      ///< smooth.comp
  kSmoothColumns,   ///< likewise
  kTotals,          ///< map_totals.comp: in one piece
  kSoftLight,       ///< soft_light.comp: the first two maps of soft_light.h
  kScatterRows,     ///< scatter.comp: from the second map to the third
  kScatterColumns,  ///< and back
  kLight,           ///< light.comp: the lit picture
  kOutline,         ///< outline.comp: from one picture to the other
  kDiffuse,         ///< diffuse.comp: likewise
  kFinish,          ///< finish.comp: the finished picture
};

/// The specialisation constants of the shaders.
struct Method {
  bool perspective = false;
  bool soft_shadows = true;
  bool soft_light = false;
  bool keeps_edges = false;  ///< of the smoothing filter
};

/// The maps of a LightPass, as the shaders' buffers of these names. Borrowed.
struct Memory {
  const shaders::LightParameters* lighting = nullptr;
  const float* volume_depth = nullptr;
  const float* confidence = nullptr;
  const std::uint32_t* volume_colour = nullptr;
  std::uint32_t* steady = nullptr;  ///< two floats a pixel
  float* tile_depths = nullptr;     ///< two a tile
  std::uint32_t* cleanup_tiles = nullptr;
  float* filled = nullptr;
  std::uint32_t* weights = nullptr;
  std::uint32_t* row_sums = nullptr;  ///< two words a pixel
  float* smooth_depth = nullptr;      ///< before, the map without islands
  shaders::MapTotals* totals = nullptr;
  std::uint32_t* soft_lights = nullptr;  ///< two words a place: half floats (shaders/soft_light.h)
  std::uint32_t* from = nullptr;         ///< the picture that the step reads: two words a pixel, half floats
  std::uint32_t* to = nullptr;           ///< the picture that it writes
  std::uint32_t* finished = nullptr;     ///< packed RGBA8 a pixel
};

/// A rectangle of pixels, or of places of 2 x 2 pixels; `right` and `bottom` are not in it.
struct Part {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
};

/// Runs a step in a part of the picture. Several threads may run a step in different parts at the same time;
/// a step needs all of those before it. Does not allocate or lock.
void run(Step step, const Method& method, const Memory& memory, const Part& part);

}  // namespace fanlight::shading
