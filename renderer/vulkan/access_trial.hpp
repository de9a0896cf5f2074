// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/base/result.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// What a trial has measured, ms for the same reads; 0: not tried.
struct AccessTrial {
  double texels_ms = 0;
  double storage_ms = 0;

  BufferAccess faster() const {
    return storage_ms > 0 && storage_ms < texels_ms ? BufferAccess::kStorage : BufferAccess::kTexels;
  }
};

/// Reads a small buffer in both ways as pass 1 does (shaders/access_trial.comp), some times each in turn, and
/// returns the shortest times. Blocks for some tens of ms, most of it the driver's compiler. Error: of
/// Vulkan.
Result<AccessTrial> try_buffer_access(const Gpu& gpu);

}  // namespace fanlight
