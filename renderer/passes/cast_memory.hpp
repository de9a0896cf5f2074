// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/base/result.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/cast_maps.hpp"
#include "renderer/pipelines/descriptor_sets.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The memory of a CastPass: parameters, tables and maps. Maps: height x width, top row first. Tiles: 8 x 8
/// rays, numbered along the rows of tiles.
struct CastMemory {
  /// `maps`: as CastMaps::create(). `tiles`: of what pass 1 knows of tiles and rays besides. Error: no memory
  /// on the GPU.
  static Result<CastMemory> create(const Gpu& gpu, PictureSize size, BufferPlace maps, BufferPlace tiles);

  void write_to(const DescriptorSets& descriptors) const;

  // Written by the host.
  GpuBuffer parameters;   ///< shaders::CastParameters
  GpuBuffer near_tissue;  ///< shaders::NearTissueParameters
  GpuBuffer staged_transfer;
  GpuBuffer cut_cells;  ///< see CutMask::write_cells()

  GpuImage transfer;
  CastMaps maps;
  GpuBuffer ray_depth;  ///< the depth as the rays found it
  // Per tile: the segments that its rays sample, those of the cast before, and how far its rays went. And the
  // list of dirty tiles.
  GpuBuffer segments;
  GpuBuffer old_segments;
  GpuBuffer reached;
  GpuBuffer tile_list;
};

}  // namespace fanlight
