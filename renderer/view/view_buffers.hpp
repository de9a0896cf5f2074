// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/base/result.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/descriptor_sets.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The memory of a view: parameters, tables, and the maps that each pass writes for the next one. Maps:
/// height x width, top row first. Tiles: 8 x 8 pixels, numbered along the rows of tiles.
struct ViewBuffers {
  /// Error: no memory on the GPU.
  static Result<ViewBuffers> create(const Gpu& gpu, PictureSize size);

  /// Writes all of it into the sets. ViewRenderer::follow() overwrites FANLIGHT_BINDING_PREVIOUS_DEPTH.
  void write_to(const Gpu& gpu, DescriptorSets& descriptors) const;

  /// Takes over what passes 2 and 3 read from pass 1: the parameters now, the maps when the GPU executes the
  /// commands. Shaders may read them afterwards.
  void copy_cast(VkCommandBuffer commands, const ViewBuffers& from);

  // Written by the host.
  GpuBuffer cast_parameters;
  GpuBuffer light_parameters;
  GpuBuffer staged_transfer;
  // Tables.
  GpuBuffer nothing;  ///< for bindings where a frame store has no buffer
  GpuImage transfer;
  // Pass 1: depth in mm, contrast divided by noise, colour as RGBA.
  GpuBuffer depth;
  GpuBuffer confidence;
  GpuBuffer volume_colour;
  // Per tile: the segments that its rays sample, those of the cast before, and how far its rays went. And the
  // list of dirty tiles.
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
  GpuBuffer row_sums;  ///< later pass 2's picture
  GpuBuffer smooth_depth;
  GpuBuffer nearest;
  // Pass 3.
  GpuBuffer diffused;
  GpuBuffer finished;
  GpuBuffer read_back;
  GpuBuffer read_back_depth;
};

}  // namespace fanlight
