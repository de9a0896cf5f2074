// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/vulkan/buffer_access.hpp"

namespace fanlight {

/// The kind of each descriptor by its binding; absent for one that is not used.
using BindingTypes = std::vector<std::optional<VkDescriptorType>>;

/// The descriptors that a SPIR-V module declares. Knows what the passes use: uniform and storage buffers,
/// texel buffers, and sampled textures, without arrays of them. Source: SPIR-V 1.6, 3.52 (instructions).
BindingTypes bindings_of(std::span<const std::uint32_t> spirv);

/// Those of all passes with this access, which share one descriptor set layout. Any thread.
const BindingTypes& binding_types(BufferAccess access);

/// Number of storage buffers among them.
std::uint32_t storage_buffers(BufferAccess access);

}  // namespace fanlight
