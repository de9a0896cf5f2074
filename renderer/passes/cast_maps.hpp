// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/base/result.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/pixel_rect.hpp"
#include "renderer/pipelines/descriptor_sets.hpp"
#include "renderer/vulkan/gpu_memory.hpp"

namespace fanlight {

/// What pass 1 passes to passes 2 and 3: height x width, top row first. LightPass reads the maps of a
/// CastPass where they are, or a copy of them.
struct CastMaps {
  /// `place`: kDevice, or, for copies by the host, kFromGpu of the original and kToGpu of the copy. Error: no
  /// memory on the GPU.
  static Result<CastMaps> create(const Gpu& gpu, PictureSize size, BufferPlace place);

  void write_to(const DescriptorSets& descriptors) const;

  /// Records a copy of `from`, maps of that size. Shaders may read it afterwards.
  void copy(VkCommandBuffer commands, const CastMaps& from, PictureSize size) const;

  /// Copies `from`, maps of that size of another device. Does not wait for a GPU. Returns the part of the
  /// maps that differs from what was there before. Reads both: quick in a processor's memory, where this is
  /// used.
  PixelRect copy_by_host(const CastMaps& from, PictureSize size) const;

  GpuBuffer depth;       ///< float, mm; FANLIGHT_NO_SURFACE without a surface
  GpuBuffer confidence;  ///< float: contrast of the edge over the noise next to it
  GpuBuffer colour;      ///< packed RGBA8; alpha: the certainty (shaders/certainty.h)
};

}  // namespace fanlight
