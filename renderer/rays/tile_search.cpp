// SPDX-License-Identifier: Apache-2.0
#include "renderer/rays/tile_search.hpp"

#include <algorithm>

#include "shaders/bindings.h"

// As ray_caster.cpp.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SSE4 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/rays/tile_search.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "renderer/rays/dirty_tiles-inl.h"
#include "renderer/rays/empty_space-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::tile_search::HWY_NAMESPACE {

void find_segments(const Method& method, const Memory& memory, std::uint32_t first, std::uint32_t end) {
  const EmptySpace space(method, memory);
  for (std::uint32_t tile = first; tile < end; ++tile) {
    if (memory.segment_masks != nullptr) {
      const SegmentMask mask = space.mask_of(tile);
      std::ranges::copy(mask, memory.segment_masks + kMaskWords * tile);
    }
    if (memory.sample_ends != nullptr) memory.sample_ends[tile] = 0;
  }
}

void find_changes(const Method& method, const Memory& memory, const ReplacedFrames& frames,
                  std::uint32_t first, std::uint32_t end, std::uint32_t* dirty) {
  const EmptySpace space(method, memory);
  const DirtyTiles changes(method, memory, frames);
  for (std::uint32_t tile = first; tile < end; ++tile) {
    const SegmentMask mask = space.mask_of(tile);
    std::uint32_t* const kept = memory.segment_masks + kMaskWords * tile;
    SegmentMask read = mask;
    for (std::size_t word = 0; word < read.size(); ++word) read[word] |= kept[word];
    std::ranges::copy(mask, kept);
    dirty[tile] = changes.is_dirty(tile, read, memory.sample_ends[tile]) ? 1 : 0;
    if (dirty[tile] != 0) memory.sample_ends[tile] = 0;
  }
}

}  // namespace fanlight::tile_search::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fanlight::tile_search {

namespace {

HWY_EXPORT(find_segments);
HWY_EXPORT(find_changes);

}  // namespace

void find_segments(const Method& method, const Memory& memory, std::uint32_t first, std::uint32_t end) {
  HWY_DYNAMIC_DISPATCH(find_segments)(method, memory, first, end);
}

void find_changes(const Method& method, const Memory& memory, const ReplacedFrames& frames,
                  std::uint32_t first, std::uint32_t end, std::uint32_t* dirty) {
  HWY_DYNAMIC_DISPATCH(find_changes)(method, memory, frames, first, end, dirty);
}

}  // namespace fanlight::tile_search
#endif
