#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

#include "proto/result.hpp"

namespace fanlight {

/// "vkQueueSubmit2 failed with VK_ERROR_DEVICE_LOST" and the like: a driver or a machine that cannot go on.
Error vulkan_error(std::string_view call, VkResult result);

}  // namespace fanlight
