// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/base/result.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/descriptor_sets.hpp"
#include "renderer/view/pixel_rect.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// The passes that a view runs. Where passes 2 and 3 have a device of their own, the view on each device has
/// the maps of its own passes, and the maps that are copied between the two are mapped.
enum class ViewPasses : std::uint8_t {
  kAll,
  kCast,  ///< passes 0 and 1
  kLight  ///< passes 2 and 3
};

/// The memory of a view: parameters, tables, and the maps that each pass writes for the next one. Maps:
/// height x width, top row first. Tiles: 8 x 8 pixels, numbered along the rows of tiles.
struct ViewBuffers {
  /// Error: no memory on the GPU.
  static Result<ViewBuffers> create(const Gpu& gpu, PictureSize size, ViewPasses passes);

  /// Writes all of it into the sets. ViewRenderer::follow() overwrites FANLIGHT_BINDING_PREVIOUS_DEPTH.
  void write_to(const Gpu& gpu, DescriptorSets& descriptors) const;

  /// Takes over what passes 2 and 3 read from pass 1: the parameters now, the maps when the GPU executes the
  /// commands. Shaders may read them afterwards.
  void copy_cast(VkCommandBuffer commands, const ViewBuffers& from);

  /// The same from ViewPasses::kCast to kLight, by the host, now. Returns the part of the maps that differs
  /// from what was there before. Reads both: quick in a processor's memory, where this is used.
  PixelRect take_cast(const ViewBuffers& from, PictureSize size) const;
  /// The temporally filtered depth map, from ViewPasses::kLight to kCast, by the host, now.
  void take_steady(const ViewBuffers& from) const;

  // Written by the host.
  GpuBuffer cast_parameters;
  GpuBuffer light_parameters;
  GpuBuffer staged_transfer;
  // Tables.
  GpuBuffer nothing;  ///< for bindings where a frame store has no buffer
  GpuImage transfer;
  // Pass 1: depth in mm, the same as the rays found it, contrast divided by noise, colour as RGBA.
  GpuBuffer depth;
  GpuBuffer ray_depth;
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
