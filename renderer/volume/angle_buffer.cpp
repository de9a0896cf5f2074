// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/angle_buffer.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "renderer/vulkan/command_recording.hpp"

namespace fanlight {

namespace {

using Pair = std::array<float, 2>;

}  // namespace

Result<AngleBuffer> AngleBuffer::create(const Gpu& gpu, std::uint64_t entries_at_most, BufferPlace place) {
  AngleBuffer made;
  const std::uint64_t bytes = entries_at_most * sizeof(Pair);
  made.is_staged_ = place == BufferPlace::kDevice;
  if (made.is_staged_) {
    auto staged = GpuBuffer::create(gpu, "staged angle table", bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                    BufferPlace::kToGpu);
    if (!staged) return staged.error();
    made.staged_ = std::move(*staged);
  }
  auto entries = GpuBuffer::create(
      gpu, "angle table", bytes, VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
      place, VK_FORMAT_R32G32_SFLOAT);
  if (!entries) return entries.error();
  made.entries_ = std::move(*entries);
  return made;
}

void AngleBuffer::put(std::span<const float> entries) {
  auto* const pairs = &(is_staged_ ? staged_ : entries_).mapped_as<Pair>();
  for (std::size_t i = 0; i < entries.size(); ++i)
    pairs[i] = {entries[i], entries[std::min(i + 1, entries.size() - 1)]};
  due_ = is_staged_;
}

void AngleBuffer::record(VkCommandBuffer commands) {
  if (!std::exchange(due_, false)) return;
  const VkBufferCopy all{.size = entries_.bytes()};
  vkCmdCopyBuffer(commands, staged_.get(), entries_.get(), 1, &all);
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT);
}

}  // namespace fanlight
