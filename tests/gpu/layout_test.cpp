// SPDX-License-Identifier: Apache-2.0
// What C++ and GLSL share: compares the offsets of structs in C++ and in the SPIR-V, and reads the kinds of
// descriptors.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>

#include "renderer/vulkan/shader_interface.hpp"
#include "shaders/bindings.h"
#include "shaders/cast_parameters.h"
#include "shaders/light_parameters.h"
#include "shaders/map_alignment.h"
#include "shaders/near_tissue.h"
#include "shaders/prepare_constants.h"
#include "shaders/spirv.hpp"
#include "shaders/steady_parameters.h"

namespace fanlight::test::layout_tests {
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

TEST(Layout, PrepareConstantsAreOneInBothLanguages) {
  const Offsets expected = {OFFSET(PrepareConstants, columns),    OFFSET(PrepareConstants, rows),
                            OFFSET(PrepareConstants, frames),     OFFSET(PrepareConstants, first_frame),
                            OFFSET(PrepareConstants, first_kept), OFFSET(PrepareConstants, radius_across),
                            OFFSET(PrepareConstants, noise),      OFFSET(PrepareConstants, levels)};
  for (const auto spirv :
       {shaders::box_spirv, shaders::median_spirv, shaders::guided_fit_spirv, shaders::guided_apply_spirv}) {
    EXPECT_EQ(offsets_in(spirv, "PrepareConstants"), expected);
  }
}

TEST(Layout, SteadyParametersAreOneInBothLanguages) {
  const Offsets view = {
      OFFSET(MapView, width),        OFFSET(MapView, left),         OFFSET(MapView, top),
      OFFSET(MapView, right),        OFFSET(MapView, bottom),       OFFSET(MapView, middle),
      OFFSET(MapView, scale_at_0),   OFFSET(MapView, scale_per_mm), OFFSET(MapView, cell_side),
      OFFSET(MapView, cells_across), OFFSET(MapView, cells_down)};
  const Offsets parameters = {OFFSET(SteadyParameters, now),          OFFSET(SteadyParameters, earlier),
                              OFFSET(SteadyParameters, right),        OFFSET(SteadyParameters, down),
                              OFFSET(SteadyParameters, forward),      OFFSET(SteadyParameters, origin),
                              OFFSET(SteadyParameters, pivot),        OFFSET(SteadyParameters, added_volumes),
                              OFFSET(SteadyParameters, most_volumes), OFFSET(SteadyParameters, seam)};
  const Offsets seam = {OFFSET(SeamParameters, along),          OFFSET(SeamParameters, across),
                        OFFSET(SeamParameters, along_at_0),     OFFSET(SeamParameters, across_at_0),
                        OFFSET(SeamParameters, frames_per_rad), OFFSET(SeamParameters, frames),
                        OFFSET(SeamParameters, same_view),      OFFSET(SeamParameters, angles),
                        OFFSET(SeamParameters, shares),         OFFSET(SeamParameters, shares_before)};
  const Offsets alignment = {
      OFFSET(MapAlignment, right),         OFFSET(MapAlignment, down),        OFFSET(MapAlignment, forward),
      OFFSET(MapAlignment, origin),        OFFSET(MapAlignment, found),       OFFSET(MapAlignment, now_cells),
      OFFSET(MapAlignment, earlier_cells), OFFSET(MapAlignment, differences), OFFSET(MapAlignment, slopes),
      OFFSET(MapAlignment, stretch),       OFFSET(MapAlignment, figures),     OFFSET(MapAlignment, doubt)};
  for (const auto spirv :
       {shaders::map_cells_spirv, shaders::map_motion_spirv, shaders::map_differences_spirv,
        shaders::map_agreement_spirv, shaders::temporal_spirv}) {
    EXPECT_EQ(offsets_in(spirv, "MapView"), view);
    EXPECT_EQ(offsets_in(spirv, "SteadyParameters"), parameters);
    EXPECT_EQ(offsets_in(spirv, "SeamParameters"), seam);
    EXPECT_EQ(offsets_in(spirv, "MapAlignment"), alignment);
  }
}

TEST(Layout, CastParametersAreOneInBothLanguages) {
  const Offsets expected = {OFFSET(CastParameters, origin),
                            OFFSET(CastParameters, right_step),
                            OFFSET(CastParameters, down_step),
                            OFFSET(CastParameters, forward),
                            OFFSET(CastParameters, right_turn),
                            OFFSET(CastParameters, down_turn),
                            OFFSET(CastParameters, right),
                            OFFSET(CastParameters, width),
                            OFFSET(CastParameters, height),
                            OFFSET(CastParameters, view_left),
                            OFFSET(CastParameters, view_top),
                            OFFSET(CastParameters, view_width),
                            OFFSET(CastParameters, view_height),
                            OFFSET(CastParameters, pixel_stride),
                            OFFSET(CastParameters, start),
                            OFFSET(CastParameters, end),
                            OFFSET(CastParameters, eye),
                            OFFSET(CastParameters, step),
                            OFFSET(CastParameters, steps),
                            OFFSET(CastParameters, angle_scale),
                            OFFSET(CastParameters, angle_offset),
                            OFFSET(CastParameters, last_angle_entry),

                            OFFSET(CastParameters, column_scale),
                            OFFSET(CastParameters, column_offset),
                            OFFSET(CastParameters, row_scale),
                            OFFSET(CastParameters, row_offset),
                            OFFSET(CastParameters, last_column),
                            OFFSET(CastParameters, last_row),
                            OFFSET(CastParameters, last_frame),
                            OFFSET(CastParameters, voxel_scale),
                            OFFSET(CastParameters, packed_stride),
                            OFFSET(CastParameters, packed_rows),
                            OFFSET(CastParameters, probe_radius),
                            OFFSET(CastParameters, left),
                            OFFSET(CastParameters, right_side),
                            OFFSET(CastParameters, first_angle),
                            OFFSET(CastParameters, last_angle),
                            OFFSET(CastParameters, motor_radius),
                            OFFSET(CastParameters, frame_angle),
                            OFFSET(CastParameters, farthest),
                            OFFSET(CastParameters, sector_tangent),
                            OFFSET(CastParameters, sector_margin),
                            OFFSET(CastParameters, sector_near_squared),
                            OFFSET(CastParameters, sector_far_squared),
                            OFFSET(CastParameters, least_seen_by_beam),
                            OFFSET(CastParameters, crop_lowest),
                            OFFSET(CastParameters, crop_highest),
                            OFFSET(CastParameters, clip1),
                            OFFSET(CastParameters, clip2),
                            OFFSET(CastParameters, cut_lowest),
                            OFFSET(CastParameters, cut_cell),
                            OFFSET(CastParameters, cut_columns),
                            OFFSET(CastParameters, cut_rows),
                            OFFSET(CastParameters, cut_layers),
                            OFFSET(CastParameters, threshold),
                            OFFSET(CastParameters, rise),
                            OFFSET(CastParameters, reach),
                            OFFSET(CastParameters, sheet_below),
                            OFFSET(CastParameters, least_tissue),
                            OFFSET(CastParameters, least_contrast),
                            OFFSET(CastParameters, edge_sign),
                            OFFSET(CastParameters, segment_shift),
                            OFFSET(CastParameters, least_seen),
                            OFFSET(CastParameters, greatest_seen),
                            OFFSET(CastParameters, across),
                            OFFSET(CastParameters, beside),
                            OFFSET(CastParameters, first_tile),
                            OFFSET(CastParameters, slab_samples),
                            OFFSET(CastParameters, slab_step),
                            OFFSET(CastParameters, slab_kind),
                            OFFSET(CastParameters, across_points),
                            OFFSET(CastParameters, slices),
                            OFFSET(CastParameters, slice_planes)};
  for (const auto spirv : {shaders::cast_spirv, shaders::slice_spirv, shaders::confidence_spirv,
                           shaders::empty_space_spirv, shaders::cast_gathering_spirv}) {
    EXPECT_EQ(offsets_in(spirv, "CastParameters"), expected);
  }
}

TEST(Layout, SlicesAreOneInBothLanguages) {
  const Offsets expected = {OFFSET(Slice, origin), OFFSET(Slice, right_step), OFFSET(Slice, down_step),
                            OFFSET(Slice, left),   OFFSET(Slice, top),        OFFSET(Slice, width),
                            OFFSET(Slice, height)};
  for (const auto spirv : {shaders::cast_spirv, shaders::slice_spirv}) {
    EXPECT_EQ(offsets_in(spirv, "Slice"), expected);
  }
}

TEST(Layout, NearTissueIsOneInBothLanguages) {
  const Offsets expected = {
      OFFSET(NearTissueParameters, start_columns),   OFFSET(NearTissueParameters, start_rows),
      OFFSET(NearTissueParameters, end_columns),     OFFSET(NearTissueParameters, end_angles),
      OFFSET(NearTissueParameters, end_first_angle), OFFSET(NearTissueParameters, row_mm),
      OFFSET(NearTissueParameters, ray_start),       OFFSET(NearTissueParameters, end_row)};
  for (const auto spirv : {shaders::cast_spirv, shaders::slice_spirv, shaders::cast_gathering_spirv}) {
    EXPECT_EQ(offsets_in(spirv, "NearTissueParameters"), expected);
  }
}

TEST(Layout, LightParametersAreOneInBothLanguages) {
  const Offsets expected = {OFFSET(LightParameters, width),
                            OFFSET(LightParameters, height),
                            OFFSET(LightParameters, view_left),
                            OFFSET(LightParameters, view_top),
                            OFFSET(LightParameters, view_right),
                            OFFSET(LightParameters, view_bottom),
                            OFFSET(LightParameters, centre),
                            OFFSET(LightParameters, pixel),
                            OFFSET(LightParameters, view_scale_at_0),
                            OFFSET(LightParameters, view_scale_per_mm),
                            OFFSET(LightParameters, eye_height),
                            OFFSET(LightParameters, same_surface),
                            OFFSET(LightParameters, islands_radius),
                            OFFSET(LightParameters, holes_radius),
                            OFFSET(LightParameters, filter_radius),
                            OFFSET(LightParameters, filter_fall),
                            OFFSET(LightParameters, sum_units),
                            OFFSET(LightParameters, confidence_counts),
                            OFFSET(LightParameters, smooth_left),
                            OFFSET(LightParameters, smooth_top),
                            OFFSET(LightParameters, smooth_right),
                            OFFSET(LightParameters, smooth_bottom),
                            OFFSET(LightParameters, lamps),
                            OFFSET(LightParameters, directional),
                            OFFSET(LightParameters, lamp_places),
                            OFFSET(LightParameters, lamp_directions),
                            OFFSET(LightParameters, lamp_colours),
                            OFFSET(LightParameters, lamp_distances),
                            OFFSET(LightParameters, light_colour),
                            OFFSET(LightParameters, material),
                            OFFSET(LightParameters, ambient),
                            OFFSET(LightParameters, diffuse),
                            OFFSET(LightParameters, specular),
                            OFFSET(LightParameters, shininess),
                            OFFSET(LightParameters, central_normals),
                            OFFSET(LightParameters, shadow),
                            OFFSET(LightParameters, softness),
                            OFFSET(LightParameters, shadow_top),
                            OFFSET(LightParameters, occlusion),
                            OFFSET(LightParameters, occlusion_reach),
                            OFFSET(LightParameters, scattered),
                            OFFSET(LightParameters, scatter_radius),
                            OFFSET(LightParameters, scatter_fall),
                            OFFSET(LightParameters, glow),
                            OFFSET(LightParameters, glow_reach),
                            OFFSET(LightParameters, fade_reach),
                            OFFSET(LightParameters, rim),
                            OFFSET(LightParameters, half_from),
                            OFFSET(LightParameters, halves_per_mm),
                            OFFSET(LightParameters, haze),
                            OFFSET(LightParameters, exposure),
                            OFFSET(LightParameters, film),
                            OFFSET(LightParameters, glass),
                            OFFSET(LightParameters, show),
                            OFFSET(LightParameters, colours_from_left),
                            OFFSET(LightParameters, depth_white),
                            OFFSET(LightParameters, depth_scale),
                            OFFSET(LightParameters, outline_radius),
                            OFFSET(LightParameters, outline_fall),
                            OFFSET(LightParameters, outline_scale),
                            OFFSET(LightParameters, mean),
                            OFFSET(LightParameters, diffusion_scale),
                            OFFSET(LightParameters, map_colours),
                            OFFSET(LightParameters, map_points)};
  for (const auto spirv :
       {shaders::temporal_spirv, shaders::tile_depth_range_spirv, shaders::cleanup_tiles_spirv,
        shaders::islands_spirv, shaders::holes_spirv, shaders::mean_rows_spirv, shaders::mean_columns_spirv,
        shaders::smooth_spirv, shaders::soft_light_spirv, shaders::scatter_spirv, shaders::light_spirv,
        shaders::outline_spirv, shaders::diffuse_spirv, shaders::finish_spirv}) {
    EXPECT_EQ(offsets_in(spirv, "LightParameters"), expected);
  }
}

#undef OFFSET

TEST(ShaderInterfaceTest, AllPassesAgreeOnTheKindOfEachBinding) {
  std::size_t compared = 0;
  for (const auto access : {BufferAccess::kTexels, BufferAccess::kStorage}) {
    const bool texels = access == BufferAccess::kTexels;
    for (const shaders::Pass& pass : shaders::passes()) {
      for (const auto spirv :
           {texels ? pass.texels : pass.storage, texels ? pass.gathering_texels : pass.gathering_storage}) {
        const BindingTypes types = bindings_of(spirv);
        ASSERT_FALSE(types.empty()) << pass.name;
        for (std::size_t binding = 0; binding < types.size(); ++binding) {
          if (!types[binding]) continue;
          EXPECT_EQ(types[binding], binding_types(access)[binding]) << pass.name << ", binding " << binding;
          ++compared;
        }
      }
    }
  }
  EXPECT_GT(compared, 200U);
}

TEST(ShaderInterfaceTest, ReadsEachKindOfDescriptor) {
  const BindingTypes& texels = binding_types(BufferAccess::kTexels);
  EXPECT_EQ(texels[FANLIGHT_BINDING_CAST_PARAMETERS], VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER);
  EXPECT_EQ(texels[FANLIGHT_BINDING_VOLUME], VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER);
  EXPECT_EQ(texels[FANLIGHT_BINDING_ANGLE_TABLE], VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);
  EXPECT_EQ(texels[FANLIGHT_BINDING_FILTERED_FRAMES], VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER);
  EXPECT_EQ(texels[FANLIGHT_BINDING_DEPTH], VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  const BindingTypes& storage = binding_types(BufferAccess::kStorage);
  EXPECT_EQ(storage[FANLIGHT_BINDING_ANGLE_TABLE], VK_DESCRIPTOR_TYPE_STORAGE_BUFFER);
  EXPECT_FALSE(storage[FANLIGHT_BINDING_BLOCK_MIN_MAX_TEXELS]) << "the same buffer as for writing";
}

}  // namespace
}  // namespace fanlight::test::layout_tests
