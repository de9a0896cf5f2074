// SPDX-License-Identifier: Apache-2.0
#include "renderer/vulkan/gpu_timestamps.hpp"

#include <algorithm>

#include "renderer/vulkan/vulkan_result.hpp"

namespace fanlight {

Result<GpuTimestamps> GpuTimestamps::create(const Gpu& gpu) {
  const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                   .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                   .queryCount = kMoments};
  VkQueryPool times = VK_NULL_HANDLE;
  const VkResult result = vkCreateQueryPool(gpu.device(), &info, nullptr, &times);
  if (result != VK_SUCCESS) return vulkan_error("vkCreateQueryPool", result);
  GpuTimestamps made;
  made.gpu_ = &gpu;
  made.times_ = QueryPoolHandle(gpu.device(), times);
  return made;
}

void GpuTimestamps::reset() const {
  vkResetQueryPool(gpu_->device(), times_.get(), 0, kMoments);
}

void GpuTimestamps::reset_piece() const {
  vkResetQueryPool(gpu_->device(), times_.get(), kPieceBegin, 2);
}

void GpuTimestamps::stamp(VkCommandBuffer commands, Moment moment) const {
  vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, times_.get(), moment);
}

/// Values of the moments in [first, end); those that were not written since the reset are 0.
std::array<std::uint64_t, GpuTimestamps::kMoments> GpuTimestamps::ticks(Moment first, Moment end) const {
  std::array<std::uint64_t, kMoments> ticks{};
  for (std::uint32_t moment = first; moment < end; ++moment) {
    const VkResult result =
        vkGetQueryPoolResults(gpu_->device(), times_.get(), moment, 1, sizeof ticks[moment], &ticks[moment],
                              sizeof ticks[moment], VK_QUERY_RESULT_64_BIT);
    if (result == VK_ERROR_DEVICE_LOST)
      gpu_->note_fault(Gpu::Condition::kLost, vulkan_error("vkGetQueryPoolResults", result));
  }
  return ticks;
}

std::array<StageSpan, kStages> GpuTimestamps::spans() const {
  const auto ticks = this->ticks(kPrepareBegin, kPieceBegin);
  const auto between = [&](Moment from, Moment to) {
    if (ticks[from] == 0 || ticks[to] <= ticks[from]) return StageSpan{};
    // A GPU may count nanoseconds since 1970: too many for the precision of a double.
    const auto ns = [&](Moment moment) {
      return static_cast<std::int64_t>(static_cast<long double>(ticks[moment]) *
                                       gpu_->limits().timestampPeriod);
    };
    return StageSpan{.begin_ns = ns(from), .end_ns = ns(to)};
  };
  return {between(kPrepareBegin, kPrepareEnd), between(kUploadBegin, kCastBegin),
          between(kCastBegin, kCastEnd),       between(kFilterBegin, kLightBegin),
          between(kLightBegin, kLightEnd),     between(kLightEnd, kFinishEnd),
          between(kFinishEnd, kReadBackEnd)};
}

std::array<double, kStages> GpuTimestamps::ms() const {
  std::array<double, kStages> ms{};
  std::ranges::transform(spans(), ms.begin(), &StageSpan::ms);
  return ms;
}

double GpuTimestamps::piece_ms() const {
  const auto ticks = this->ticks(kPieceBegin, kMoments);
  if (ticks[kPieceBegin] == 0 || ticks[kPieceEnd] <= ticks[kPieceBegin]) return 0;
  return static_cast<double>(ticks[kPieceEnd] - ticks[kPieceBegin]) * gpu_->limits().timestampPeriod / 1e6;
}

}  // namespace fanlight
