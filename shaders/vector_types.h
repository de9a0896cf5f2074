// The text of a struct in *_parameters.h is read by C++ and by GLSL alike. In C++ the vectors are GLM's,
// whose sizes equal those of GLSL's scalar block layout; a test compares every offset with the SPIR-V's own.
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
// The only element of the parameters, in dispatches one group deep, at an offset that no compiler knows: where Mesa's
// lavapipe (22.3) knows the offset of a value that alone decides a branch, it makes a shader of its own for that value,
// anew at every dispatch, and keeps them all.
#define FANLIGHT_THE_ONLY gl_WorkGroupID.z
#endif

#endif
