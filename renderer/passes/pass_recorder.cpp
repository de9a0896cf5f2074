// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/pass_recorder.hpp"

#include <utility>

#include "renderer/vulkan/command_recording.hpp"
#include "renderer/vulkan/debug_name.hpp"
#include "renderer/vulkan/vulkan_result.hpp"

namespace fanlight {

Result<PassRecorder> PassRecorder::create(const PassDevice& device, const Config& config) {
  PassRecorder made;
  made.device_ = device;
  made.pauses_ = config.pauses;
  if (auto commands = made.create_commands(config.name); !commands) return commands.error();
  auto descriptors = DescriptorSets::create(device);
  if (!descriptors) return descriptors.error();
  made.descriptors_ = std::move(*descriptors);
  auto timestamps = GpuTimestamps::create(*device.gpu);
  if (!timestamps) return timestamps.error();
  made.timestamps_ = std::move(*timestamps);
  auto timeline = SubmissionTimeline::create(*device.gpu, config.name);
  if (!timeline) return timeline.error();
  made.timeline_ = std::move(*timeline);
  return made;
}

Result<void> PassRecorder::create_commands(const char* name) {
  const VkDevice device = gpu().device();
  const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = gpu().candidate().queue_family};
  VkCommandPool pool = VK_NULL_HANDLE;
  VkResult result = vkCreateCommandPool(device, &pool_info, nullptr, &pool);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateCommandPool", result);
  command_pool_ = CommandPoolHandle(device, pool);
  const VkCommandBufferAllocateInfo buffer_info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = 1};
  result = vkAllocateCommandBuffers(device, &buffer_info, &commands_);
  if (result != VK_SUCCESS) return vulkan_error("vkAllocateCommandBuffers", result);
  set_debug_name(gpu(), commands_, name);
  return {};
}

Result<VkCommandBuffer> PassRecorder::begin() const {
  thread_owner_.check();
  if (auto begun = begin_commands(commands_); !begun) return begun.error();
  descriptors_.bind(commands_, DescriptorSets::Order::kLitToDiffused);
  return commands_;
}

void PassRecorder::begin_piece(Stage stage) {
  if (!pauses_) return;
  done_ms_ = stage_ms();
  timestamps_.reset_piece();
  piece_stage_ = stage;
  in_piece_ = true;
  stamp(GpuTimestamps::kPieceBegin);
}

Result<void> PassRecorder::submit(VkQueue queue, const TimelinePoint& other) {
  thread_owner_.check();
  if (std::exchange(in_piece_, false)) stamp(GpuTimestamps::kPieceEnd);
  return timeline_.submit(queue, commands_, other);
}

void PassRecorder::reset_times() {
  timestamps_.reset();
  done_ms_ = {};
}

std::array<double, kStages> PassRecorder::stage_ms() const {
  if (!pauses_) return timestamps_.ms();
  auto ms = done_ms_;
  ms[static_cast<std::size_t>(piece_stage_)] += timestamps_.piece_ms();
  return ms;
}

}  // namespace fanlight
