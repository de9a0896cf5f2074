// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/pipeline_key.hpp"

#include "shaders/spirv.hpp"

namespace fanlight {

std::string_view name_of(Shader shader) {
  return shaders::passes()[static_cast<std::size_t>(shader)].name;
}

}  // namespace fanlight
