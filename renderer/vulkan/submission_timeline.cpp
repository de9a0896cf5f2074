// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/submission_timeline.hpp"

#include <algorithm>

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
  made.semaphore_ = SemaphoreHandle(gpu.device(), semaphore);
  set_debug_name(gpu, semaphore, name);
  return made;
}

Result<void> SubmissionTimeline::submit(VkQueue queue, VkCommandBuffer commands, const TimelinePoint& other) {
  VkResult result = vkEndCommandBuffer(commands);
  if (result != VK_SUCCESS) return vulkan_error("vkEndCommandBuffer", result);
  const VkSemaphoreSubmitInfo after[] = {{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = semaphore_.get(),
                                          .value = submissions_,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT},
                                         {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                          .semaphore = other.semaphore,
                                          .value = other.value,
                                          .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT}};
  const VkSemaphoreSubmitInfo done{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                   .semaphore = semaphore_.get(),
                                   .value = submissions_ + 1,
                                   .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
  const VkCommandBufferSubmitInfo buffer{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                         .commandBuffer = commands};
  const VkSubmitInfo2 info{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                           .waitSemaphoreInfoCount = other.semaphore == VK_NULL_HANDLE ? 1U : 2U,
                           .pWaitSemaphoreInfos = after,
                           .commandBufferInfoCount = 1,
                           .pCommandBufferInfos = &buffer,
                           .signalSemaphoreInfoCount = 1,
                           .pSignalSemaphoreInfos = &done};
  result = vkQueueSubmit2(queue, 1, &info, VK_NULL_HANDLE);
  if (result != VK_SUCCESS) return vulkan_error("vkQueueSubmit2", result);
  ++submissions_;
  submitted_ns_ = now_ns();
  return {};
}

std::uint64_t SubmissionTimeline::outstanding(const Gpu& gpu) const {
  std::uint64_t reached = 0;
  vkGetSemaphoreCounterValue(gpu.device(), semaphore_.get(), &reached);
  return submissions_ - std::min(reached, submissions_);
}

Result<void> SubmissionTimeline::wait(const Gpu& gpu, std::uint64_t timeout_ns) const {
  const VkSemaphore semaphore = semaphore_.get();
  const VkSemaphoreWaitInfo info{.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                 .semaphoreCount = 1,
                                 .pSemaphores = &semaphore,
                                 .pValues = &submissions_};
  const VkResult result = vkWaitSemaphores(gpu.device(), &info, timeout_ns);
  if (result != VK_SUCCESS && result != VK_TIMEOUT) return vulkan_error("vkWaitSemaphores", result);
  return {};
}

}  // namespace fanlight
