// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "proto/base/result.hpp"
#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// A value of a timeline semaphore. Work that waits for it runs after the submission that signals it.
struct TimelinePoint {
  VkSemaphore semaphore = VK_NULL_HANDLE;
  std::uint64_t value = 0;

  bool operator==(const TimelinePoint&) const = default;
};

/// Submits command buffers one after the other: each waits for the one before, also on another queue. Owns
/// the timeline semaphore that counts them. Render thread only.
///
/// A submission for which there was no memory is held: it counts as submitted, and retry() submits it again.
/// So a short lack of memory costs time only.
class SubmissionTimeline {
 public:
  /// A lack of memory that lasts longer is an error.
  static constexpr std::int64_t kPatienceNs = 1'000'000'000;

  SubmissionTimeline() = default;
  /// `gpu` must outlive the result.
  static Result<SubmissionTimeline> create(const Gpu& gpu, const char* name);

  /// Ends the command buffer and submits it. It runs after the submission before it and after `other`, where
  /// that has a semaphore. Does not block. The command buffer must stay as it is until the submission is
  /// done.
  Result<void> submit(VkQueue queue, VkCommandBuffer commands, const TimelinePoint& other);

  /// Submits a held submission, if there is one. Error: kUnavailable where there was no memory for
  /// kPatienceNs.
  Result<void> retry();

  bool holds() const { return held_.has_value(); }

  /// Forgets a held submission; its commands never run.
  void drop_held();

  /// Reached when everything that was submitted is done.
  TimelinePoint newest() const { return {.semaphore = semaphore_.get(), .value = submissions_}; }

  /// When the last submission was made (fanlight::now_ns).
  std::int64_t submitted_ns() const { return submitted_ns_; }

  /// Number of submissions so far.
  std::uint64_t submissions() const { return submissions_; }

  /// Number of submissions that the GPU is not known to have finished. Where the GPU cannot be asked, that is
  /// all of them; a lost device is noted (Gpu::note_fault).
  std::uint64_t outstanding() const;

  /// Blocks until everything that was submitted is done, at most timeout_ns. A time-out is no error.
  Result<void> wait(std::uint64_t timeout_ns) const;

 private:
  struct Submission {
    VkQueue queue = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    TimelinePoint other;
  };
  VkResult submit_held() const;

  const Gpu* gpu_ = nullptr;
  SemaphoreHandle semaphore_;
  std::uint64_t submissions_ = 0;
  std::int64_t submitted_ns_ = 0;
  std::optional<Submission> held_;  // the last submission, while the driver has not taken it
};

}  // namespace fanlight
