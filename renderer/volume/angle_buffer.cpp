// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/angle_buffer.hpp"

#include <cstring>
#include <utility>

#include "renderer/vulkan/command_recording.hpp"

namespace fanlight {

Result<AngleBuffer> AngleBuffer::create(const Gpu& gpu, std::uint64_t bytes) {
  AngleBuffer made;
  auto staged = GpuBuffer::create(gpu, "staged angle table", bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                  BufferPlace::kToGpu);
  if (!staged) return staged.error();
  made.staged_ = std::move(*staged);
  auto entries = GpuBuffer::create(
      gpu, "angle table", bytes, VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
      BufferPlace::kDevice, VK_FORMAT_R32_SFLOAT);
  if (!entries) return entries.error();
  made.entries_ = std::move(*entries);
  return made;
}

void AngleBuffer::put(std::span<const float> entries) {
  std::memcpy(staged_.mapped().data(), entries.data(), entries.size_bytes());
  due_ = true;
}

void AngleBuffer::record(VkCommandBuffer commands) {
  if (!std::exchange(due_, false)) return;
  const VkBufferCopy all{.size = entries_.bytes()};
  vkCmdCopyBuffer(commands, staged_.get(), entries_.get(), 1, &all);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
}

}  // namespace fanlight
