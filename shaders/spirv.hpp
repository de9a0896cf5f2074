#pragma once

#include <cstdint>
#include <span>

namespace fanlight::shaders {

// The SPIR-V words of each pass, embedded when the project is built.
extern const std::span<const std::uint32_t> cast_spirv;
extern const std::span<const std::uint32_t> filter_rows_spirv;
extern const std::span<const std::uint32_t> filter_columns_spirv;
extern const std::span<const std::uint32_t> light_spirv;
extern const std::span<const std::uint32_t> finish_spirv;

}  // namespace fanlight::shaders
