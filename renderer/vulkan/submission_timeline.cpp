// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/submission_timeline.hpp"

#include "proto/base/clock.hpp"
#include "renderer/vulkan/debug_name.hpp"
#include "renderer/vulkan/vulkan_result.hpp"

namespace fanlight {

Result<SubmissionTimeline> SubmissionTimeline::create(const Gpu& gpu, const char* name) {
  const VkSemaphoreTypeCreateInfo type{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                       .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
  const VkSemaphoreCreateInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
  VkSemaphore semaphore = VK_NULL_HANDLE;
  const VkResult result = vkCreateSemaphore(gpu.device(), &info, nullptr, &semaphore);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateSemaphore", result);
  SubmissionTimeline made;
  made.gpu_ = &gpu;
  made.semaphore_ = SemaphoreHandle(gpu.device(), semaphore);
  set_debug_name(gpu, semaphore, name);
  return made;
}

Result<void> SubmissionTimeline::submit(VkQueue queue, VkCommandBuffer commands, const TimelinePoint& other) {
  const VkResult result = vkEndCommandBuffer(commands);
  if (result != VK_SUCCESS) return vulkan_error("vkEndCommandBuffer", result);
  held_ = Submission{.queue = queue, .commands = commands, .other = other};
  ++submissions_;
  submitted_ns_ = now_ns();
  return retry();
}

Result<void> SubmissionTimeline::retry() {
  if (!held_) return {};
  const VkResult result = submit_held();
  // Without memory the driver has changed nothing, so that the same submission can be made again.
  if (is_out_of_memory(result) && now_ns() - submitted_ns_ < kPatienceNs) return {};
  if (result != VK_SUCCESS) {
    drop_held();
    return vulkan_error("vkQueueSubmit2", result);
  }
  held_.reset();
  return {};
}

void SubmissionTimeline::drop_held() {
  if (!held_) return;
  held_.reset();
  --submissions_;
}

VkResult SubmissionTimeline::submit_held() const {
  const TimelinePoint& other = held_->other;
  const VkSemaphoreSubmitInfo after[] = {{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = semaphore_.get(),
                                          .value = submissions_ - 1,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
                                         {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = other.semaphore,
                                          .value = other.value,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT}};
  const VkSemaphoreSubmitInfo done{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                   .semaphore = semaphore_.get(),
                                   .value = submissions_,
                                   .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
  const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                         .commandBuffer = held_->commands};
  const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .waitSemaphoreInfoCount = other.semaphore == VK_NULL_HANDLE ? 1U : 2U,
                           .pWaitSemaphoreInfos = after,
                           .commandBufferInfoCount = 1,
                           .pCommandBufferInfos = &buffer,
                           .signalSemaphoreInfoCount = 1,
                           .pSignalSemaphoreInfos = &done};
  return vkQueueSubmit2(held_->queue, 1, &info, VK_NULL_HANDLE);
}

std::uint64_t SubmissionTimeline::outstanding() const {
  std::uint64_t reached = 0;
  const VkResult result = vkGetSemaphoreCounterValue(gpu_->device(), semaphore_.get(), &reached);
  if (result == VK_SUCCESS && reached <= submissions_) return submissions_ - reached;
  // Only what the GPU is known to have done may be read. Some drivers answer for a lost device with a value
  // that no submission has signalled.
  if (!is_out_of_memory(result)) {
    gpu_->note_fault(Gpu::Condition::kLost,
                     result == VK_SUCCESS
                         ? Error{ErrorCode::kLost,
                                 "a semaphore has a value that was never submitted, as after a loss "
                                 "of the device; expected one that was"}
                         : vulkan_error("vkGetSemaphoreCounterValue", result));
  }
  return submissions_;
}

Result<void> SubmissionTimeline::wait(std::uint64_t timeout_ns) const {
  const VkSemaphore semaphore = semaphore_.get();
  const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                 .semaphoreCount = 1,
                                 .pSemaphores = &semaphore,
                                 .pValues = &submissions_};
  const VkResult result = vkWaitSemaphores(gpu_->device(), &info, timeout_ns);
  // Without memory to wait, the next look at the counter is as good.
  if (result == VK_SUCCESS || result == VK_TIMEOUT || is_out_of_memory(result)) return {};
  return vulkan_error("vkWaitSemaphores", result);
}

}  // namespace fanlight
