#pragma once

#include <cstdint>

#include "proto/result.hpp"
#include "renderer/descriptor_sets.hpp"
#include "renderer/gpu_memory.hpp"
#include "renderer/view.hpp"

namespace fanlight {

/// The memory of a view: parameters and tables, and the maps that each pass leaves
/// for the next, all of the picture's size. Maps: height x width, top row first; tiles of 8 x 8 pixels along
/// the rows of tiles.
struct SlotMemory {
  /// Error: memory that the GPU refuses.
  static Result<SlotMemory> create(const Gpu& gpu, PictureSize size);

  /// Names all of it in the sets; a view that follows another writes FANLIGHT_BINDING_PREVIOUS anew.
  void write_to(const Gpu& gpu, DescriptorSets& descriptors) const;

  /// Of it, what passes 2 and 3 take from pass 1.
  void write_cast_to(const Gpu& gpu, DescriptorSets& descriptors) const;

  // Written by the host.
  GpuBuffer cast_parameters;
  GpuBuffer light_parameters;
  GpuBuffer staged_transfer;
  // Tables.
  GpuBuffer nothing;  ///< stands where a frame store has no buffer
  GpuImage transfer;
  // Pass 1: mm, contrast over noise, RGBA.
  GpuBuffer depth;
  GpuBuffer confidence;
  GpuBuffer volume_colour;
  // Of each tile: the segments that its rays sample, those of the cast before, how far a ray looked, and the
  // tiles to cast again.
  GpuBuffer segments;
  GpuBuffer old_segments;
  GpuBuffer reached;
  GpuBuffer tile_list;
  // Pass 2.
  GpuBuffer steady;
  GpuBuffer tile_depths;
  GpuBuffer uneven;
  GpuBuffer filled;
  GpuBuffer weights;
  GpuBuffer row_sums;  ///< then pass 2's picture
  GpuBuffer smooth_depth;
  GpuBuffer nearest;
  // Pass 3.
  GpuBuffer diffused;
  GpuBuffer finished;
  GpuBuffer read_back;
  GpuBuffer read_back_depth;
};

}  // namespace fanlight
