// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <string>

#include "proto/base/result.hpp"
#include "proto/model/picture_size.hpp"

namespace fanlight {

// What a Renderer makes of errors, and what it refuses.

/// Whether pictures of both sizes fit the GPU. Error: kInvalidArgument.
Result<void> check_sizes(PictureSize usual, PictureSize largest, const VkPhysicalDeviceLimits& limits);

/// Adds the needed memory to an error about missing memory; other errors stay as they are.
Error too_large(const Error& error, const std::string& gpu, std::uint64_t volume_bytes);

/// Whether an error of a volume's memory is more than a refusal of that volume.
bool is_breakage(const Error& error);

/// An error after a volume was taken is no refusal of it.
Result<void> as_breakage(Result<void> done);

/// A submission that the GPU has not finished for that time.
Error not_finished_for(std::int64_t time_ns);

}  // namespace fanlight
