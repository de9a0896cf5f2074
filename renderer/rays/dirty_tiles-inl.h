// SPDX-License-Identifier: Apache-2.0
// The tiles whose rays replaced frames can have changed: shaders/dirty_tiles.comp, a segment a lane. See
// there for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_RAYS_DIRTY_TILES) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_RAYS_DIRTY_TILES
#undef FANLIGHT_RENDERER_RAYS_DIRTY_TILES
#else
#define FANLIGHT_RENDERER_RAYS_DIRTY_TILES
#endif

#include <algorithm>

#include "renderer/rays/empty_space-inl.h"
#include "renderer/rays/tile_bounds-inl.h"
#include "renderer/rays/tile_search.hpp"
#include "shaders/bindings.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::tile_search::HWY_NAMESPACE {

class DirtyTiles {
 public:
  DirtyTiles(const Method& method, const Memory& memory, const ReplacedFrames& frames)
      : rays_(*memory.rays), frames_(frames), bounds_(*memory.rays, memory.angle_table, memory.rays->beside) {
    const int samples = 1 << rays_.segment_shift;
    half_length_ = 0.5F * static_cast<float>(samples + method.window);
    if (method.place == FANLIGHT_PLACE_LEVEL) half_length_ += 0.5F * static_cast<float>(method.window);
    first_middle_ = 0.5F * static_cast<float>(samples - method.window);
  }

  // `read`: the segments that rays read or will read, up to sample `sample_end`.
  bool is_dirty(std::uint32_t tile, const SegmentMask& read, std::uint32_t sample_end) const {
    const int count = segments_before(std::min(sample_end, rays_.steps), rays_.segment_shift);
    if (count == 0 || std::ranges::all_of(read, [](std::uint32_t word) { return word == 0; })) return false;
    const TileLines lines = bounds_.lines_of(tile);
    constexpr int kStep = static_cast<int>(kLanes);
    for (int segment = 0; segment < count; segment += kStep) {
      // A word has whole vectors of segments.
      const std::uint32_t word = read[static_cast<std::size_t>(segment / 32)];
      std::uint32_t bits = word >> static_cast<std::uint32_t>(segment % 32) & kAllLanes;
      if (count - segment < kStep) bits &= (1U << static_cast<std::uint32_t>(count - segment)) - 1U;
      if (bits != 0 && (bits & bits_of(mixes_changed(lines, segment))) != 0) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kAllLanes = (1U << kLanes) - 1U;

  // Whether samples of the segments from `first` on interpolate a replaced frame.
  Mask mixes_changed(const TileLines& lines, int first) const {
    const Floats number = hn::Iota(kFloats, static_cast<float>(first));
    const Floats samples = all(static_cast<float>(1 << rays_.segment_shift));
    const Range frames =
        bounds_.frames_in(bounds_.extent_of(lines, {number * samples + all(first_middle_), half_length_}));
    return hn::And(hn::Le(frames.first, all(static_cast<float>(frames_.last))),
                   hn::Ge(frames.last, all(static_cast<float>(frames_.first))));
  }

  const shaders::CastParameters& rays_;
  ReplacedFrames frames_;
  TileBounds bounds_;
  float half_length_ = 0;
  float first_middle_ = 0;
};

}  // namespace fanlight::tile_search::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
