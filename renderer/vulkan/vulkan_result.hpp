// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// The error of a failed Vulkan call, for example "vkQueueSubmit2 failed with VK_ERROR_DEVICE_LOST". Code:
/// kUnavailable where memory ran out, kLost where the device was lost, otherwise kBroken.
Error vulkan_error(std::string_view call, VkResult result);

/// Whether the result says that memory of the GPU or of the host ran out. The call has then changed nothing.
bool is_out_of_memory(VkResult result);

}  // namespace fanlight
