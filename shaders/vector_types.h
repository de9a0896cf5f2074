// SPDX-License-Identifier: Apache-2.0
// Lets C++ and GLSL compile the same struct (*_parameters.h, prepare_constants.h). In C++ the vectors are
// those of GLM, whose sizes equal those of GLSL's scalar block layout. tests/gpu/layout_test.cpp compares
// every offset with the SPIR-V.
#ifndef FANLIGHT_SHADERS_VECTOR_TYPES_H
#define FANLIGHT_SHADERS_VECTOR_TYPES_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
namespace fanlight::shaders {
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = std::uint32_t;
}  // namespace fanlight::shaders
#define FANLIGHT_SHADER_STRUCT(name) \
  namespace fanlight::shaders {      \
  struct name
#define FANLIGHT_SHADER_STRUCT_END \
  ;                                \
  }
#else
#define FANLIGHT_SHADER_STRUCT(name) struct name
#define FANLIGHT_SHADER_STRUCT_END ;
// Dynamic index of the only element of the parameter array: 0, because dispatches are one group deep. It is a
// work-around for a leak in Mesa 22.3: if a uniform at a constant offset alone decides a branch, lavapipe
// compiles a variant of the shader for its value at every dispatch, and keeps all of them.
#define FANLIGHT_PARAMETER_INDEX gl_WorkGroupID.z
#endif

#endif
