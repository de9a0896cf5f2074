// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// The error of a failed Vulkan call, for example "vkQueueSubmit2 failed with VK_ERROR_DEVICE_LOST". Code:
/// kUnavailable where memory ran out, otherwise kBroken.
Error vulkan_error(std::string_view call, VkResult result);

}  // namespace fanlight
