// SPDX-License-Identifier: Apache-2.0
// ViewRenderer: copies of the depth maps, for tests and one-shot rendering.
#include <algorithm>
#include <bit>
#include <functional>
#include <iterator>
#include <numeric>

#include "renderer/view/view_renderer.hpp"
#include "renderer/vulkan/command_recording.hpp"

namespace fanlight {

Result<DepthMaps> ViewRenderer::read_depth() {
  // Without passes 2 and 3 there is no filtered map: VolumeInFlight::read_depth() has it from their device.
  const GpuBuffer& smooth = memory_.smooth_depth.bytes() > 0 ? memory_.smooth_depth : memory_.depth;
  const GpuBuffer* const maps[] = {&memory_.depth, &memory_.confidence, &smooth};
  const std::uint64_t maps_bytes = std::size(maps) * memory_.depth.bytes();
  auto copy = GpuBuffer::create(*device_.gpu, "depth map copies", maps_bytes + memory_.segments.bytes(),
                                VK_BUFFER_USAGE_TRANSFER_DST_BIT, BufferPlace::kFromGpu);
  if (!copy) return copy.error();
  if (auto begun = begin_commands(light_commands_); !begun) return begun.error();
  for (std::size_t map = 0; map < std::size(maps); ++map) {
    const VkBufferCopy region{.dstOffset = map * memory_.depth.bytes(), .size = memory_.depth.bytes()};
    vkCmdCopyBuffer(light_commands_, maps[map]->get(), copy->get(), 1, &region);
  }
  const VkBufferCopy region{.dstOffset = maps_bytes, .size = memory_.segments.bytes()};
  vkCmdCopyBuffer(light_commands_, memory_.segments.get(), copy->get(), 1, &region);
  barrier(light_commands_, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  if (auto submitted = timeline_.submit(device_.gpu->light_queue(), light_commands_, other_work_); !submitted)
    return submitted.error();
  constexpr std::uint64_t kMostNs = 60'000'000'000;  // copies only
  if (auto waited = timeline_.wait(*device_.gpu, kMostNs); !waited) return waited.error();
  if (timeline_.outstanding(*device_.gpu) > 0) {
    const Error hung{ErrorCode::kLost, "the GPU did not copy the depth maps within a minute"};
    device_.gpu->note_fault(Gpu::Condition::kHung, hung);
    return hung;
  }
  const auto* values = reinterpret_cast<const float*>(copy->mapped().data());
  const auto map = [&](std::size_t index) {
    return std::vector<float>(values + index * pixels(), values + (index + 1) * pixels());
  };
  const auto* words = reinterpret_cast<const std::uint32_t*>(copy->mapped().data() + maps_bytes);
  const std::uint64_t sampled = std::transform_reduce(
      words, words + cast_tiles_ * sizeof(glm::uvec4) / sizeof *words, std::uint64_t{0}, std::plus(),
      [](std::uint32_t word) { return static_cast<std::uint64_t>(std::popcount(word)); });
  const auto segments = static_cast<double>(std::uint64_t{cast_tiles_} * segments_in_ray_);
  return DepthMaps{.cast_mm = map(0),
                   .confidence = confidence_known_ ? map(1) : std::vector<float>(),
                   .smooth_mm = map(2),
                   .sampled_share = cast_pipelines_.empty_space == VK_NULL_HANDLE
                                        ? 1
                                        : static_cast<double>(sampled) / std::max(segments, 1.0)};
}

}  // namespace fanlight
