// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/light_memory.hpp"

#include <algorithm>
#include <utility>

#include "renderer/passes/pixel_rect.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "shaders/bindings.h"
#include "shaders/light_parameters.h"
#include "shaders/map_alignment.h"
#include "shaders/map_totals.h"
#include "shaders/steady_parameters.h"

namespace fanlight {

Result<LightMemory> LightMemory::create(const Gpu& gpu, PictureSize size, BufferPlace steady_place,
                                        BufferPlace usual_place) {
  LightMemory made;
  const std::uint64_t pixels = std::uint64_t{size.width} * size.height;
  const std::uint64_t tiles = std::uint64_t{groups(size.width, kTileSide)} * groups(size.height, kTileSide);
  // Three maps of soft light lie in the memory of the diffusion (shaders/soft_light.h). Pictures of up to 6 x
  // 6 pixels have no room for them.
  const std::uint64_t places = std::uint64_t{(size.width + 1) / 2} * ((size.height + 1) / 2);
  constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  constexpr VkBufferUsageFlags kRead = kStorage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  constexpr VkBufferUsageFlags kFilled = kStorage | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  const WantedBuffer buffers[] = {
      {"light_parameters", &made.parameters, sizeof(shaders::LightParameters),
       VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, BufferPlace::kToGpu},
      {"steady_parameters", &made.steady_parameters, sizeof(shaders::SteadyParameters),
       VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, BufferPlace::kToGpu},
      {"steady", &made.steady, pixels * sizeof(glm::vec2), kFilled | kRead, steady_place},
      {"tile_depths", &made.tile_depths, tiles * sizeof(glm::vec2), kStorage, usual_place},
      {"uneven", &made.uneven, tiles * sizeof(std::uint32_t), kStorage, usual_place},
      {"filled", &made.filled, pixels * sizeof(float), kStorage, usual_place},
      {"weights", &made.weights, pixels * sizeof(std::uint32_t), kStorage, usual_place},
      {"row_sums", &made.row_sums, std::max(pixels * sizeof(glm::uvec2), sizeof(shaders::MapAlignment)),
       kStorage, usual_place},
      {"smooth_depth", &made.smooth_depth, pixels * sizeof(float), kRead, usual_place},
      {"map_totals", &made.map_totals, sizeof(shaders::MapTotals), kFilled | kRead, usual_place},
      {"diffused", &made.diffused, std::max(pixels, 3 * places) * sizeof(glm::uvec2), kStorage, usual_place},
      {"finished", &made.finished, pixels * sizeof(std::uint32_t), kRead},
      {"read_back", &made.read_back, pixels * sizeof(std::uint32_t), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
       BufferPlace::kFromGpu},
      {"read_back_depth", &made.read_back_depth, pixels * sizeof(float), VK_BUFFER_USAGE_TRANSFER_DST_BIT,
       BufferPlace::kFromGpu},
      {"read_back_colours", &made.read_back_colours, pixels * sizeof(std::uint32_t),
       VK_BUFFER_USAGE_TRANSFER_DST_BIT, BufferPlace::kFromGpu},
      {"read_back_totals", &made.read_back_totals, sizeof(shaders::MapTotals),
       VK_BUFFER_USAGE_TRANSFER_DST_BIT, BufferPlace::kFromGpu}};
  if (auto created = create_buffers(gpu, buffers); !created) return created.error();
  return made;
}

void LightMemory::write_to(const DescriptorSets& descriptors) const {
  const std::pair<std::uint32_t, const GpuBuffer*> buffers[] = {
      {FANLIGHT_BINDING_LIGHT_PARAMETERS, &parameters},
      {FANLIGHT_BINDING_STEADY_PARAMETERS, &steady_parameters},
      {FANLIGHT_BINDING_EARLIER_MAP, &steady},
      {FANLIGHT_BINDING_STEADY_MAP, &steady},
      // The depth map without islands is stored where the filtered one will be.
      {FANLIGHT_BINDING_CLEANED, &smooth_depth},
      {FANLIGHT_BINDING_TILE_DEPTH_RANGES, &tile_depths},
      {FANLIGHT_BINDING_CLEANUP_TILES, &uneven},
      {FANLIGHT_BINDING_FILLED, &filled},
      {FANLIGHT_BINDING_WEIGHTS, &weights},
      {FANLIGHT_BINDING_ROW_SUMS, &row_sums},
      {FANLIGHT_BINDING_SMOOTH_DEPTH, &smooth_depth},
      {FANLIGHT_BINDING_MAP_TOTALS, &map_totals},
      {FANLIGHT_BINDING_LIT, &row_sums},
      {FANLIGHT_BINDING_DIFFUSED, &diffused},
      {FANLIGHT_BINDING_FINISHED, &finished}};
  for (const auto& [binding, buffer] : buffers) descriptors.write(binding, *buffer);
}

}  // namespace fanlight
