// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/cast_maps.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"

namespace fanlight {

namespace {

std::span<const std::uint32_t> words_of(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const std::uint32_t*>(bytes.data()), bytes.size() / sizeof(std::uint32_t)};
}

/// The smallest rectangle around the pixels that differ, bit by bit, in two maps of a word a pixel.
PixelRect different_part(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b, int width) {
  PixelRect part;
  const auto columns = static_cast<std::size_t>(width);
  for (std::size_t row = 0; row * columns < a.size(); ++row) {
    const auto in_a = a.subspan(row * columns, columns);
    const auto in_b = b.subspan(row * columns, columns);
    if (std::memcmp(in_a.data(), in_b.data(), in_a.size_bytes()) == 0) continue;
    const auto first = std::ranges::mismatch(in_a, in_b).in1 - in_a.begin();
    const auto behind = std::mismatch(in_a.rbegin(), in_a.rend(), in_b.rbegin()).first - in_a.rbegin();
    const auto y = static_cast<int>(row);
    part = part.united({static_cast<int>(first), y, width - static_cast<int>(behind), y + 1});
  }
  return part;
}

}  // namespace

Result<CastMaps> CastMaps::create(const Gpu& gpu, PictureSize size, BufferPlace place) {
  CastMaps made;
  const std::uint64_t pixels = std::uint64_t{size.width} * size.height;
  constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                        VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  const WantedBuffer buffers[] = {
      {"depth", &made.depth, pixels * sizeof(float), kUsage, place},
      {"confidence", &made.confidence, pixels * sizeof(float), kUsage, place},
      {"volume_colour", &made.colour, pixels * sizeof(std::uint32_t), kUsage, place}};
  if (auto created = create_buffers(gpu, buffers); !created) return created.error();
  return made;
}

void CastMaps::write_to(const DescriptorSets& descriptors) const {
  descriptors.write(FANLIGHT_BINDING_DEPTH, depth);
  descriptors.write(FANLIGHT_BINDING_CONFIDENCE, confidence);
  descriptors.write(FANLIGHT_BINDING_VOLUME_COLOUR, colour);
}

void CastMaps::copy(VkCommandBuffer commands, const CastMaps& from, PictureSize size) const {
  const std::pair<const GpuBuffer*, const GpuBuffer*> maps[] = {
      {&from.depth, &depth}, {&from.confidence, &confidence}, {&from.colour, &colour}};
  for (const auto& [source, copy] : maps) {
    const VkBufferCopy map{.size = size.pixels() * sizeof(std::uint32_t)};
    vkCmdCopyBuffer(commands, source->get(), copy->get(), 1, &map);
  }
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_READ_BIT);
}

PixelRect CastMaps::copy_by_host(const CastMaps& from, PictureSize size) const {
  const std::pair<const GpuBuffer*, const GpuBuffer*> maps[] = {
      {&from.depth, &depth}, {&from.confidence, &confidence}, {&from.colour, &colour}};
  PixelRect changed;
  for (const auto& [source, copy] : maps) {
    const std::size_t bytes = size.pixels() * sizeof(std::uint32_t);
    const std::span<const std::uint8_t> now = source->mapped().first(bytes);
    const std::span<std::uint8_t> before = copy->mapped().first(bytes);
    changed = changed.united(different_part(words_of(now), words_of(before), static_cast<int>(size.width)));
    std::ranges::copy(now, before.begin());
  }
  return changed;
}

}  // namespace fanlight
