// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace fanlight::shaders {

using Words = std::span<const std::uint32_t>;

// The SPIR-V words of each pass, embedded by the build: NAME_spirv, and its variants, NAME_storage_spirv for
// storage buffers in place of texel buffers (buffer_access.h), NAME_gathering_spirv for packed words in place
// of a texture (fan_volume.h), and NAME_gathering_storage_spirv for both.
#define FANLIGHT_DECLARE_PLAIN(name) extern const Words name##_spirv;
#define FANLIGHT_DECLARE_INDEXING(name) \
  FANLIGHT_DECLARE_PLAIN(name)          \
  FANLIGHT_DECLARE_PLAIN(name##_storage)
#define FANLIGHT_DECLARE_SAMPLING(name) \
  FANLIGHT_DECLARE_INDEXING(name)       \
  FANLIGHT_DECLARE_INDEXING(name##_gathering)
#define FANLIGHT_PASS(name, enumerator, variants, pipelines) FANLIGHT_DECLARE_##variants(name)
#include "shaders/passes.inc"
FANLIGHT_DECLARE_INDEXING(access_trial)
#undef FANLIGHT_DECLARE_PLAIN
#undef FANLIGHT_DECLARE_INDEXING
#undef FANLIGHT_DECLARE_SAMPLING

/// A row of passes.inc. If a pass lacks a variant, its member is the next simpler variant.
struct Pass {
  std::string_view name;  ///< of its file
  Words texels;
  Words storage;
  Words gathering_texels;
  Words gathering_storage;
  bool has_fixed_pipeline = false;
};

#define FANLIGHT_MODULES_PLAIN(name) name##_spirv, name##_spirv, name##_spirv, name##_spirv
#define FANLIGHT_MODULES_INDEXING(name) name##_spirv, name##_storage_spirv, name##_spirv, name##_storage_spirv
#define FANLIGHT_MODULES_SAMPLING(name) \
  name##_spirv, name##_storage_spirv, name##_gathering_spirv, name##_gathering_storage_spirv
#define FANLIGHT_IS_FIXED true
#define FANLIGHT_IS_KEYED false
/// All passes, in their order.
inline std::span<const Pass> passes() {
  static const auto kPasses = std::to_array<Pass>({
#define FANLIGHT_PASS(name, enumerator, variants, pipelines) \
  {#name, FANLIGHT_MODULES_##variants(name), FANLIGHT_IS_##pipelines},
#include "shaders/passes.inc"
  });
  return kPasses;
}
#undef FANLIGHT_MODULES_PLAIN
#undef FANLIGHT_MODULES_INDEXING
#undef FANLIGHT_MODULES_SAMPLING
#undef FANLIGHT_IS_FIXED
#undef FANLIGHT_IS_KEYED

}  // namespace fanlight::shaders
