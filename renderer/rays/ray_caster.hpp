// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "shaders/cast_parameters.h"
#include "shaders/near_tissue.h"

/// Pass 1 on a processor: the same rays as cast.comp, which GPUs run, and processors where is_fast() is
/// false. Compiled for several instruction sets by Highway; a vector of rays is cast at a time. Two and a
/// half to three times as fast as the shader on lavapipe with AVX2 and AVX-512 (decision renderer/017).
///
/// Results are those of the shader but for the rounding of a sample to 2^-19, which may go the other way: a
/// surface moves by less than a thousandth of a sample then. They are the same on all instruction sets.
namespace fanlight::ray_caster {

/// Whether the processor gathers words: without that, the shader is as fast.
bool is_fast();

/// What a cast does besides its parameters: the specialisation constants of cast.comp.
struct Method {
  int window = 8;       ///< samples of the detector, even, at most kMostWindow
  int kept = 0;         ///< FANLIGHT_KEEP_...
  int frames = 0;       ///< FANLIGHT_FRAMES_...
  int place = 0;        ///< FANLIGHT_PLACE_...
  int across = 0;       ///< a sample is the mean of 3 k points across the ray
  bool skips = true;    ///< rays skip the segments whose bits are not set
  int sign = 0;         ///< +1 dark to bright, -1 bright to dark, 0 either
  bool counts = false;  ///< `sample_ends` gets the samples that were read
};
inline constexpr int kMostWindow = 32;

/// The memory of a cast, as the shader's buffers of these names (cast.comp). Borrowed.
struct Memory {
  const shaders::CastParameters* rays = nullptr;
  const shaders::NearTissueParameters* near_tissue = nullptr;
  const std::uint32_t* packed_columns = nullptr;
  const float* angle_table = nullptr;  ///< entries alone: a pair begins at each
  const float* transfer = nullptr;     ///< red, green, blue and opacity of each of 256 grey levels
  const std::uint32_t* cut_cells = nullptr;
  const std::uint32_t* segment_masks = nullptr;  ///< four words for each tile
  float* depth = nullptr;
  float* ray_depth = nullptr;
  std::uint32_t* volume_colour = nullptr;
  std::uint32_t* sample_ends = nullptr;  ///< null where they are not wanted
};

/// Casts the rays of the tiles from `first` to before `end`, numbered along the rows of tiles. With
/// `tile_list`, these are places in the list. Precondition: the window is at most kMostWindow. Several
/// threads may cast different tiles of one picture at the same time. Does not allocate or lock.
void cast_tiles(const Method& method, const Memory& memory, std::uint32_t first, std::uint32_t end,
                const std::uint32_t* tile_list = nullptr);

}  // namespace fanlight::ray_caster
