// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_buffers.hpp"

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>

#include "renderer/parameters/transfer_table.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"
#include "shaders/cast_parameters.h"
#include "shaders/light_parameters.h"

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

Result<ViewBuffers> ViewBuffers::create(const Gpu& gpu, PictureSize size, ViewPasses passes) {
  ViewBuffers made;
  const std::uint64_t pixels = std::uint64_t{size.width} * size.height;
  const std::uint64_t tiles = std::uint64_t{groups(size.width, kTileSide)} * groups(size.height, kTileSide);
  constexpr VkBufferUsageFlags kStorage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;

  constexpr VkBufferUsageFlags kCopied = kStorage | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  constexpr VkBufferUsageFlags kFilled =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;

  const bool casts = passes != ViewPasses::kLight;
  const bool lights = passes != ViewPasses::kCast;
  // From pass 1 to passes 2 and 3, and back: mapped where the two have different devices.
  const bool copied_by_host = passes != ViewPasses::kAll;
  const auto mapped_or_device = [&](bool written_by_gpu) {
    if (!copied_by_host) return BufferPlace::kDevice;
    return written_by_gpu ? BufferPlace::kFromGpu : BufferPlace::kToGpu;
  };
  const BufferPlace cast_map = mapped_or_device(casts);
  const BufferPlace steady_map = mapped_or_device(lights);

  struct Wanted {
    const char* name;
    GpuBuffer* buffer;
    std::uint64_t bytes;
    VkBufferUsageFlags usage;
    BufferPlace place;
    bool used = true;
  };
  const Wanted buffers[] = {
      {"cast_parameters", &made.cast_parameters, sizeof(shaders::CastParameters),
       VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, BufferPlace::kToGpu},
      {"light_parameters", &made.light_parameters, sizeof(shaders::LightParameters),
       VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, BufferPlace::kToGpu},
      {"staged_transfer", &made.staged_transfer, sizeof(TransferTable), VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
       BufferPlace::kToGpu},
      {"depth", &made.depth, pixels * sizeof(float), kCopied, cast_map},
      {"ray_depth", &made.ray_depth, pixels * sizeof(float), kCopied, BufferPlace::kDevice, casts},
      {"confidence", &made.confidence, pixels * sizeof(float), kCopied, cast_map},
      {"segments", &made.segments, tiles * sizeof(glm::uvec4), kStorage, BufferPlace::kDevice},
      {"old_segments", &made.old_segments, tiles * sizeof(glm::uvec4), kFilled, BufferPlace::kDevice},
      {"reached", &made.reached, tiles * sizeof(std::uint32_t), kFilled, BufferPlace::kDevice},
      {"tile_list", &made.tile_list, (3 + tiles) * sizeof(std::uint32_t),
       kFilled | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, BufferPlace::kDevice},
      {"volume_colour", &made.volume_colour, pixels * sizeof(std::uint32_t), kCopied, cast_map},
      {"steady", &made.steady, pixels * sizeof(float), kStorage, steady_map},
      {"tile_depths", &made.tile_depths, tiles * sizeof(glm::vec2), kStorage, BufferPlace::kDevice},
      {"uneven", &made.uneven, tiles * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice},
      {"filled", &made.filled, pixels * sizeof(float), kStorage, BufferPlace::kDevice, lights},
      {"weights", &made.weights, pixels * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice, lights},
      {"row_sums", &made.row_sums, pixels * sizeof(glm::uvec2), kStorage, BufferPlace::kDevice, lights},
      {"smooth_depth", &made.smooth_depth, pixels * sizeof(float), kStorage, BufferPlace::kDevice, lights},
      {"nearest", &made.nearest, sizeof(std::uint32_t),
       VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, BufferPlace::kDevice},
      {"diffused", &made.diffused, pixels * sizeof(glm::uvec2), kStorage, BufferPlace::kDevice, lights},
      {"finished", &made.finished, pixels * sizeof(std::uint32_t), kStorage, BufferPlace::kDevice, lights},
      {"read_back", &made.read_back, pixels * sizeof(std::uint32_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
       BufferPlace::kFromGpu, lights},
      {"read_back_depth", &made.read_back_depth, pixels * sizeof(float), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
       BufferPlace::kFromGpu, lights},
  };
  for (const Wanted& wanted : buffers) {
    if (!wanted.used) continue;
    auto buffer = GpuBuffer::create(gpu, wanted.name, wanted.bytes, wanted.usage, wanted.place);
    if (!buffer) return buffer.error();
    *wanted.buffer = std::move(*buffer);
  }

  auto nothing =
      GpuBuffer::create(gpu, "nothing", sizeof(std::uint32_t),
                        VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                            VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT,
                        BufferPlace::kDevice, VK_FORMAT_R32_UINT);
  if (!nothing) return nothing.error();
  made.nothing = std::move(*nothing);
  auto transfer =
      GpuImage::create(gpu, "transfer", VK_FORMAT_R32G32B32A32_SFLOAT, {TransferTable().size(), 1, 1});
  if (!transfer) return transfer.error();
  made.transfer = std::move(*transfer);
  return made;
}

void ViewBuffers::write_to(const Gpu& gpu, DescriptorSets& descriptors) const {
  const std::pair<std::uint32_t, const GpuBuffer*> buffers[] = {
      {FANLIGHT_BINDING_CAST_PARAMETERS, &cast_parameters},
      {FANLIGHT_BINDING_LIGHT_PARAMETERS, &light_parameters},
      {FANLIGHT_BINDING_DEPTH, &depth},
      {FANLIGHT_BINDING_RAY_DEPTH, &ray_depth},
      {FANLIGHT_BINDING_VOLUME_COLOUR, &volume_colour},
      {FANLIGHT_BINDING_CONFIDENCE, &confidence},
      {FANLIGHT_BINDING_SEGMENT_MASKS, &segments},
      {FANLIGHT_BINDING_OLD_SEGMENT_MASKS, &old_segments},
      {FANLIGHT_BINDING_SAMPLE_ENDS, &reached},
      {FANLIGHT_BINDING_DIRTY_TILES, &tile_list},
      {FANLIGHT_BINDING_PREVIOUS_DEPTH, &steady},
      {FANLIGHT_BINDING_TEMPORAL_DEPTH, &steady},
      // The depth map without islands is stored where the filtered one will be.
      {FANLIGHT_BINDING_CLEANED, &smooth_depth},
      {FANLIGHT_BINDING_TILE_DEPTH_RANGES, &tile_depths},
      {FANLIGHT_BINDING_CLEANUP_TILES, &uneven},
      {FANLIGHT_BINDING_FILLED, &filled},
      {FANLIGHT_BINDING_WEIGHTS, &weights},
      {FANLIGHT_BINDING_ROW_SUMS, &row_sums},
      {FANLIGHT_BINDING_SMOOTH_DEPTH, &smooth_depth},
      {FANLIGHT_BINDING_MIN_DEPTH, &nearest},
      {FANLIGHT_BINDING_LIT, &row_sums},
      {FANLIGHT_BINDING_DIFFUSED, &diffused},
      {FANLIGHT_BINDING_FINISHED, &finished}};
  // Every descriptor must name an existing object, also where no pipeline uses it: lavapipe reads all of
  // them.
  const auto existing = [this](const GpuBuffer* buffer) -> const GpuBuffer& {
    return buffer != nullptr && buffer->bytes() > 0 ? *buffer : nothing;
  };
  for (const auto& [binding, buffer] : buffers) descriptors.write(gpu, binding, existing(buffer));
  descriptors.write(gpu, FANLIGHT_BINDING_TRANSFER, transfer);
}

void ViewBuffers::copy_cast(VkCommandBuffer commands, const ViewBuffers& from) {
  cast_parameters.mapped_as<shaders::CastParameters>() =
      from.cast_parameters.mapped_as<shaders::CastParameters>();
  const std::pair<const GpuBuffer*, const GpuBuffer*> maps[] = {{&from.depth, &depth},
                                                                {&from.ray_depth, &ray_depth},
                                                                {&from.confidence, &confidence},
                                                                {&from.volume_colour, &volume_colour}};
  for (const auto& [source, copy] : maps) {
    if (copy->bytes() == 0) continue;
    const VkBufferCopy all{.size = copy->bytes()};
    vkCmdCopyBuffer(commands, source->get(), copy->get(), 1, &all);
  }
  barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
}

PixelRect ViewBuffers::take_cast(const ViewBuffers& from, PictureSize size) const {
  const std::pair<const GpuBuffer*, const GpuBuffer*> maps[] = {
      {&from.depth, &depth}, {&from.confidence, &confidence}, {&from.volume_colour, &volume_colour}};
  PixelRect changed;
  for (const auto& [source, copy] : maps) {
    const std::span<const std::uint8_t> now = source->mapped();
    const std::span<std::uint8_t> before = copy->mapped();
    changed = changed.united(different_part(words_of(now), words_of(before), static_cast<int>(size.width)));
    std::ranges::copy(now, before.begin());
  }
  return changed;
}

void ViewBuffers::take_steady(const ViewBuffers& from) const {
  std::ranges::copy(from.steady.mapped(), steady.mapped().begin());
}

}  // namespace fanlight
