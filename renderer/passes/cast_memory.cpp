// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/cast_memory.hpp"

#include <utility>

#include "renderer/parameters/cast_parameters.hpp"
#include "renderer/parameters/cut_mask.hpp"
#include "renderer/passes/pixel_rect.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"
#include "shaders/cast_parameters.h"
#include "shaders/near_tissue.h"

namespace fanlight {

Result<CastMemory> CastMemory::create(const Gpu& gpu, PictureSize size, BufferPlace maps,
                                      BufferPlace tiles_place) {
  CastMemory made;
  const std::uint64_t pixels = std::uint64_t{size.width} * size.height;
  const std::uint64_t tiles = std::uint64_t{groups(size.width, kTileSide)} * groups(size.height, kTileSide);
  constexpr VkBufferUsageFlags kRead = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  constexpr VkBufferUsageFlags kFilled =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  constexpr std::uint64_t kMostCutBytes =
      std::uint64_t{CutGrid::kMostCells} * CutGrid::kMostCells * CutGrid::kMostCells;
  const WantedBuffer buffers[] = {
      {"cast_parameters", &made.parameters, sizeof(shaders::CastParameters),
       VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, BufferPlace::kToGpu},
      {"near_tissue", &made.near_tissue, sizeof(shaders::NearTissueParameters),
       VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, BufferPlace::kToGpu},
      {"staged_transfer", &made.staged_transfer, sizeof(TransferTable), VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
       BufferPlace::kToGpu},
      {"cut_cells", &made.cut_cells, kMostCutBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kToGpu},
      {"ray_depth", &made.ray_depth, pixels * sizeof(float), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, tiles_place},
      {"segments", &made.segments, tiles * sizeof(glm::uvec4), kRead, tiles_place},
      {"old_segments", &made.old_segments, tiles * sizeof(glm::uvec4), kFilled},
      {"reached", &made.reached, tiles * sizeof(std::uint32_t), kRead | kFilled, tiles_place},
      {"tile_list", &made.tile_list, (3 + tiles) * sizeof(std::uint32_t),
       kFilled | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, tiles_place}};
  if (auto created = create_buffers(gpu, buffers); !created) return created.error();
  auto cast_maps = CastMaps::create(gpu, size, maps);
  if (!cast_maps) return cast_maps.error();
  made.maps = std::move(*cast_maps);
  auto transfer =
      GpuImage::create(gpu, "transfer", VK_FORMAT_R32G32B32A32_SFLOAT, {TransferTable().size(), 1, 1});
  if (!transfer) return transfer.error();
  made.transfer = std::move(*transfer);
  return made;
}

void CastMemory::write_to(const DescriptorSets& descriptors) const {
  maps.write_to(descriptors);
  const std::pair<std::uint32_t, const GpuBuffer*> buffers[] = {
      {FANLIGHT_BINDING_CAST_PARAMETERS, &parameters}, {FANLIGHT_BINDING_NEAR_TISSUE, &near_tissue},
      {FANLIGHT_BINDING_CUT_CELLS, &cut_cells},        {FANLIGHT_BINDING_RAY_DEPTH, &ray_depth},
      {FANLIGHT_BINDING_SEGMENT_MASKS, &segments},     {FANLIGHT_BINDING_OLD_SEGMENT_MASKS, &old_segments},
      {FANLIGHT_BINDING_SAMPLE_ENDS, &reached},        {FANLIGHT_BINDING_DIRTY_TILES, &tile_list}};
  for (const auto& [binding, buffer] : buffers) descriptors.write(binding, *buffer);
  descriptors.write(FANLIGHT_BINDING_TRANSFER, transfer);
}

}  // namespace fanlight
