// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>

#include "proto/model/scene.hpp"
#include "renderer/parameters/pipeline_key.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "shaders/light_parameters.h"

namespace fanlight {

// Passes 2 and 3: scene to uniforms and pipelines.

/// The uniforms of passes 2 and 3. No surface lies deeper than `farthest_mm`. Lengths in mm, in the view
/// frame.
shaders::LightParameters light_parameters(const Scene& scene, PictureSize size, double farthest_mm);

/// The pipelines of pass 2 that depend on the scene.
struct LightKeys {
  PipelineKey filter_rows;                ///< Shader::kMeanRows or kSmooth
  PipelineKey filter_columns;             ///< Shader::kMeanColumns or kSmooth
  std::optional<PipelineKey> soft_light;  ///< where the light needs it
  std::optional<PipelineKey> scatter_rows;
  std::optional<PipelineKey> scatter_columns;
  PipelineKey light;
};
LightKeys light_keys(const Scene& scene);

/// Of the temporal filter: the cells of this map or of the earlier one; and its last step, by
/// FANLIGHT_TEMPORAL_...
PipelineKey map_cells_key(bool earlier);
PipelineKey temporal_key(int kind);

// Every value that keys can have, to be built before a scene needs them: a changed light or filter must not
// wait for a pipeline.

inline constexpr std::size_t kTemporalVariants = 5;
/// Of the temporal filter.
std::array<PipelineKey, kTemporalVariants> temporal_variants();
inline constexpr std::size_t kLightVariants = 18;
/// Of the light and of the smoothing filter.
std::array<PipelineKey, kLightVariants> light_variants();

/// The displayed colours (sRGB, 0 to 1) of a map for a brightness of 0, 1/3, 2/3 and 1; linear in between.
std::array<glm::dvec3, FANLIGHT_MAP_POINTS> colour_map_points(ColourMap map);

}  // namespace fanlight
