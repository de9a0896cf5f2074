// The structs that C++ and GLSL share: every offset in C++ against the offset that the SPIR-V states.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>

#include "shaders/cast_parameters.h"
#include "shaders/light_parameters.h"
#include "shaders/spirv.hpp"

namespace fanlight::test {
namespace {

using Offsets = std::map<std::string, std::size_t>;

/// Offsets of the members of the struct of that name, from OpName, OpMemberName and OpMemberDecorate.
Offsets offsets_in(std::span<const std::uint32_t> spirv, const std::string& name) {
  constexpr std::uint32_t kHeaderWords = 5;
  constexpr std::uint32_t kOpName = 5;
  constexpr std::uint32_t kOpMemberName = 6;
  constexpr std::uint32_t kOpMemberDecorate = 72;
  constexpr std::uint32_t kDecorationOffset = 35;
  const auto text = [&](std::size_t word) {
    return std::string(reinterpret_cast<const char*>(&spirv[word]));
  };

  std::uint32_t wanted = 0;
  std::map<std::uint32_t, std::string> members;
  std::map<std::uint32_t, std::size_t> offsets;
  for (std::size_t at = kHeaderWords; at < spirv.size(); at += spirv[at] >> 16) {
    const std::uint32_t operation = spirv[at] & 0xFFFFU;
    if (operation == kOpName && text(at + 2) == name) wanted = spirv[at + 1];
    if (operation != kOpMemberName && operation != kOpMemberDecorate) continue;
    if (spirv[at + 1] != wanted) continue;
    if (operation == kOpMemberName) members[spirv[at + 2]] = text(at + 3);
    if (operation == kOpMemberDecorate && spirv[at + 3] == kDecorationOffset)
      offsets[spirv[at + 2]] = spirv[at + 4];
  }
  Offsets named;
  for (const auto& [index, member] : members) named[member] = offsets[index];
  return named;
}

#define OFFSET(type, member) \
  { #member, offsetof(shaders::type, member) }

TEST(Layout, CastParametersAreOneInBothLanguages) {
  const Offsets expected = {OFFSET(CastParameters, origin),
                            OFFSET(CastParameters, right_step),
                            OFFSET(CastParameters, down_step),
                            OFFSET(CastParameters, forward),
                            OFFSET(CastParameters, width),
                            OFFSET(CastParameters, height),
                            OFFSET(CastParameters, steps),
                            OFFSET(CastParameters, start),
                            OFFSET(CastParameters, step),
                            OFFSET(CastParameters, table_scale),
                            OFFSET(CastParameters, table_offset),
                            OFFSET(CastParameters, column_scale),
                            OFFSET(CastParameters, column_offset),
                            OFFSET(CastParameters, row_scale),
                            OFFSET(CastParameters, row_offset),
                            OFFSET(CastParameters, last_row),
                            OFFSET(CastParameters, voxel_scale),
                            OFFSET(CastParameters, left),
                            OFFSET(CastParameters, right),
                            OFFSET(CastParameters, first_angle),
                            OFFSET(CastParameters, last_angle),
                            OFFSET(CastParameters, last_frame),
                            OFFSET(CastParameters, motor_radius),
                            OFFSET(CastParameters, farthest),
                            OFFSET(CastParameters, sector_radius),
                            OFFSET(CastParameters, sector_tangent),
                            OFFSET(CastParameters, sector_margin),
                            OFFSET(CastParameters, sector_near_squared),
                            OFFSET(CastParameters, sector_far_squared),
                            OFFSET(CastParameters, threshold),
                            OFFSET(CastParameters, edge_sign),
                            OFFSET(CastParameters, transparent),
                            OFFSET(CastParameters, ramp_scale),
                            OFFSET(CastParameters, step_opacity)};
  EXPECT_EQ(offsets_in(shaders::cast_spirv, "CastParameters"), expected);
}

TEST(Layout, LightParametersAreOneInBothLanguages) {
  const Offsets expected = {OFFSET(LightParameters, width),       OFFSET(LightParameters, height),
                            OFFSET(LightParameters, pixel),       OFFSET(LightParameters, filter_radius),
                            OFFSET(LightParameters, light),       OFFSET(LightParameters, ambient),
                            OFFSET(LightParameters, diffuse),     OFFSET(LightParameters, specular),
                            OFFSET(LightParameters, shininess),   OFFSET(LightParameters, shadow),
                            OFFSET(LightParameters, shadow_top),  OFFSET(LightParameters, skin),
                            OFFSET(LightParameters, show_volume), OFFSET(LightParameters, mean)};
  for (const auto spirv : {shaders::filter_rows_spirv, shaders::filter_columns_spirv, shaders::light_spirv,
                           shaders::finish_spirv}) {
    EXPECT_EQ(offsets_in(spirv, "LightParameters"), expected);
  }
}

#undef OFFSET

}  // namespace
}  // namespace fanlight::test
