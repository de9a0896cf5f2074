#pragma once

#include <cstdint>
#include <span>

namespace fanlight::shaders {

// The SPIR-V words of each pass, embedded when the project is built.
extern const std::span<const std::uint32_t> box_spirv;
extern const std::span<const std::uint32_t> median_spirv;
extern const std::span<const std::uint32_t> guide_spirv;
extern const std::span<const std::uint32_t> guided_spirv;
extern const std::span<const std::uint32_t> blocks_spirv;
extern const std::span<const std::uint32_t> bounds_spirv;
extern const std::span<const std::uint32_t> pack_spirv;
extern const std::span<const std::uint32_t> segments_spirv;
extern const std::span<const std::uint32_t> changed_spirv;
extern const std::span<const std::uint32_t> cast_spirv;
extern const std::span<const std::uint32_t> slice_spirv;
extern const std::span<const std::uint32_t> steady_spirv;
extern const std::span<const std::uint32_t> tiles_spirv;
extern const std::span<const std::uint32_t> uneven_spirv;
extern const std::span<const std::uint32_t> islands_spirv;
extern const std::span<const std::uint32_t> confidence_spirv;
extern const std::span<const std::uint32_t> holes_spirv;
extern const std::span<const std::uint32_t> mean_rows_spirv;
extern const std::span<const std::uint32_t> mean_columns_spirv;
extern const std::span<const std::uint32_t> smooth_spirv;
extern const std::span<const std::uint32_t> nearest_spirv;
extern const std::span<const std::uint32_t> light_spirv;
extern const std::span<const std::uint32_t> diffuse_spirv;
extern const std::span<const std::uint32_t> finish_spirv;
extern const std::span<const std::uint32_t> cast_gathering_spirv;
extern const std::span<const std::uint32_t> slice_gathering_spirv;
extern const std::span<const std::uint32_t> confidence_gathering_spirv;

}  // namespace fanlight::shaders
