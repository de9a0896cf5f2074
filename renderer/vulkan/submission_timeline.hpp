// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/base/result.hpp"
#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// A value of a timeline semaphore. Work that waits for it runs after the submission that signals it.
struct TimelinePoint {
  VkSemaphore semaphore = VK_NULL_HANDLE;
  std::uint64_t value = 0;
};

/// Submits command buffers one after the other: each waits for the one before, also on another queue. Owns
/// the timeline semaphore that counts them. Render thread only.
class SubmissionTimeline {
 public:
  SubmissionTimeline() = default;
  static Result<SubmissionTimeline> create(const Gpu& gpu, const char* name);

  /// Ends the command buffer and submits it. It runs after the submission before it and after `other`, where
  /// that has a semaphore. Does not block.
  Result<void> submit(VkQueue queue, VkCommandBuffer commands, const TimelinePoint& other);

  /// Reached when everything that was submitted is done.
  TimelinePoint newest() const { return {.semaphore = semaphore_.get(), .value = submissions_}; }

  /// When the last submission was made (fanlight::now_ns).
  std::int64_t submitted_ns() const { return submitted_ns_; }

  /// Number of submissions that the GPU has not finished.
  std::uint64_t outstanding(const Gpu& gpu) const;

  /// Blocks until everything that was submitted is done, at most timeout_ns. A time-out is no error.
  Result<void> wait(const Gpu& gpu, std::uint64_t timeout_ns) const;

 private:
  SemaphoreHandle semaphore_;
  std::uint64_t submissions_ = 0;
  std::int64_t submitted_ns_ = 0;
};

}  // namespace fanlight
