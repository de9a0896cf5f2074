// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "renderer/rays/ray_caster.hpp"
#include "shaders/cast_parameters.h"

/// What pass 1 finds out about tiles of 8 x 8 rays before it casts them, on a processor: empty_space.comp and
/// dirty_tiles.comp, which GPUs run. Compiled for several instruction sets by Highway; a vector of segments
/// of a tile is bounded at a time.
namespace fanlight::tile_search {

using ray_caster::Method;

/// The memory of a search, as the shaders' buffers of these names. Borrowed.
struct Memory {
  const shaders::CastParameters* rays = nullptr;
  const float* angle_table = nullptr;                ///< as ray_caster::Memory
  const std::uint32_t* neighbour_min_max = nullptr;  ///< a word for each block of the frames
  std::uint32_t* segment_masks = nullptr;  ///< four words for each tile; null where they are not wanted
  std::uint32_t* sample_ends = nullptr;    ///< of each tile; null where they are not wanted
};

// Tiles from `first` to before `end`, numbered along the rows of tiles. Several threads may search different
// tiles at the same time. Neither allocates nor locks.

/// Before all rays are cast: writes the masks of the segments that can hold an edge or a visible sample, and
/// 0 as the ends.
void find_segments(const Method& method, const Memory& memory, std::uint32_t first, std::uint32_t end);

/// By ascending angle; both ends were replaced.
struct ReplacedFrames {
  int first = 0;
  int last = 0;
};
/// After frames were replaced: writes the new masks, and 1 into `dirty`, a word for each tile, where the
/// result of a ray may change, else 0. The ends of dirty tiles get 0. Precondition: the masks and the ends
/// are wanted, and are those of the cast before.
void find_changes(const Method& method, const Memory& memory, const ReplacedFrames& frames,
                  std::uint32_t first, std::uint32_t end, std::uint32_t* dirty);

}  // namespace fanlight::tile_search
