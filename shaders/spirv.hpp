// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace fanlight::shaders {

/// The SPIR-V words of each pass, embedded by the build. `..._gathering`: reads the volume from packed words
/// instead of a texture (fan_volume.h). `..._storage`: reads storage buffers instead of texel buffers
/// (buffer_access.h).
extern const std::span<const std::uint32_t> box_spirv;
extern const std::span<const std::uint32_t> median_spirv;
extern const std::span<const std::uint32_t> guided_fit_spirv;
extern const std::span<const std::uint32_t> guided_apply_spirv;
extern const std::span<const std::uint32_t> block_min_max_spirv;
extern const std::span<const std::uint32_t> neighbour_min_max_spirv;
extern const std::span<const std::uint32_t> pack_spirv;
extern const std::span<const std::uint32_t> empty_space_spirv;
extern const std::span<const std::uint32_t> dirty_tiles_spirv;
extern const std::span<const std::uint32_t> cast_spirv;
extern const std::span<const std::uint32_t> frame_steps_spirv;
extern const std::span<const std::uint32_t> slice_spirv;
extern const std::span<const std::uint32_t> temporal_spirv;
extern const std::span<const std::uint32_t> tile_depth_range_spirv;
extern const std::span<const std::uint32_t> cleanup_tiles_spirv;
extern const std::span<const std::uint32_t> islands_spirv;
extern const std::span<const std::uint32_t> confidence_spirv;
extern const std::span<const std::uint32_t> holes_spirv;
extern const std::span<const std::uint32_t> mean_rows_spirv;
extern const std::span<const std::uint32_t> mean_columns_spirv;
extern const std::span<const std::uint32_t> smooth_spirv;
extern const std::span<const std::uint32_t> min_depth_spirv;
extern const std::span<const std::uint32_t> soft_light_spirv;
extern const std::span<const std::uint32_t> scatter_spirv;
extern const std::span<const std::uint32_t> light_spirv;
extern const std::span<const std::uint32_t> diffuse_spirv;
extern const std::span<const std::uint32_t> finish_spirv;
extern const std::span<const std::uint32_t> access_trial_spirv;
extern const std::span<const std::uint32_t> cast_gathering_spirv;
extern const std::span<const std::uint32_t> slice_gathering_spirv;
extern const std::span<const std::uint32_t> confidence_gathering_spirv;
extern const std::span<const std::uint32_t> access_trial_storage_spirv;
extern const std::span<const std::uint32_t> box_storage_spirv;
extern const std::span<const std::uint32_t> median_storage_spirv;
extern const std::span<const std::uint32_t> guided_fit_storage_spirv;
extern const std::span<const std::uint32_t> guided_apply_storage_spirv;
extern const std::span<const std::uint32_t> block_min_max_storage_spirv;
extern const std::span<const std::uint32_t> neighbour_min_max_storage_spirv;
extern const std::span<const std::uint32_t> pack_storage_spirv;
extern const std::span<const std::uint32_t> empty_space_storage_spirv;
extern const std::span<const std::uint32_t> dirty_tiles_storage_spirv;
extern const std::span<const std::uint32_t> frame_steps_storage_spirv;
extern const std::span<const std::uint32_t> cast_storage_spirv;
extern const std::span<const std::uint32_t> slice_storage_spirv;
extern const std::span<const std::uint32_t> confidence_storage_spirv;
extern const std::span<const std::uint32_t> cast_gathering_storage_spirv;
extern const std::span<const std::uint32_t> slice_gathering_storage_spirv;
extern const std::span<const std::uint32_t> confidence_gathering_storage_spirv;

}  // namespace fanlight::shaders
