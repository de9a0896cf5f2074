// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/base/result.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/pipelines/descriptor_sets.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The memory of a LightPass besides its input: parameters, and the maps that each step writes for the next
/// one. Maps: height x width, top row first. Tiles: 8 x 8 pixels, numbered along the rows of tiles.
struct LightMemory {
  /// `steady_place`: kDevice, or kFromGpu where the host copies that map to another device. `usual_place`: of
  /// what the light reads and writes: kDevice, or kFromGpu where the processor lights. Error: no memory on
  /// the GPU.
  static Result<LightMemory> create(const Gpu& gpu, PictureSize size, BufferPlace steady_place,
                                    BufferPlace usual_place);

  void write_to(const DescriptorSets& descriptors) const;

  GpuBuffer parameters;         ///< shaders::LightParameters, written by the host
  GpuBuffer steady_parameters;  ///< shaders::SteadyParameters, written by the host
  // Pass 2.
  GpuBuffer steady;  ///< the temporally filtered depth map: vec2 a pixel, depth and volumes
  GpuBuffer tile_depths;
  GpuBuffer uneven;
  GpuBuffer filled;
  GpuBuffer weights;
  GpuBuffer row_sums;  ///< before shaders::MapAlignment, later pass 2's picture
  GpuBuffer smooth_depth;
  GpuBuffer map_totals;  ///< shaders::MapTotals
  // Pass 3.
  GpuBuffer diffused;
  GpuBuffer finished;
  GpuBuffer read_back;
  GpuBuffer read_back_depth;
  GpuBuffer read_back_colours;
  GpuBuffer read_back_totals;
};

}  // namespace fanlight
