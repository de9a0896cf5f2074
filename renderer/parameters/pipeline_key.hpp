// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <compare>
#include <cstdint>

namespace fanlight {

/// The shaders, in the order in which they run: the rows of shaders/passes.inc, and of shaders::passes().
enum class Shader : std::uint8_t {
#define FANLIGHT_PASS(name, enumerator, variants, pipelines) enumerator,
#include "shaders/passes.inc"
};

/// Identifies a compute pipeline: a shader and the values of its specialisation constants 0, 1, ... A shader
/// ignores the constants that it does not declare; these are 0 here.
struct PipelineKey {
  Shader shader = Shader::kCast;
  std::array<std::int32_t, 8> constants{};

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy 14 takes the zero inside <=> for a pointer
  auto operator<=>(const PipelineKey&) const = default;
};

}  // namespace fanlight
