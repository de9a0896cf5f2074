// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec4.hpp>
#include <optional>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/scene.hpp"
#include "proto/model/transfer_function.hpp"
#include "renderer/parameters/angle_table.hpp"
#include "renderer/parameters/cut_mask.hpp"
#include "renderer/parameters/pipeline_key.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "shaders/cast_parameters.h"

namespace fanlight {

// Pass 1: scene to uniforms and pipelines.

/// The greatest grey value of a frame: shaders work on 0 to 1, the scene on 0 to 255.
inline constexpr double kGreyLevels = 255;

/// What a volume adds to the geometry of its source.
struct VolumeExtent {
  double first_angle_rad = 0;  ///< smallest and largest angle of its frames
  double last_angle_rad = 0;
  std::uint32_t frames = 0;
  std::uint32_t frame_capacity = 0;  ///< slices of the texture that holds it

  /// Mean angle between neighbouring frames.
  double frame_step_rad() const { return (last_angle_rad - first_angle_rad) / (std::max(frames, 2U) - 1); }
};

/// The uniforms of pass 1 for this scene and volume. Samples lie at depths rays.start_mm + k * step / (length
/// of the ray per mm of depth) for whole k. Lengths in mm, in the transducer frame.
shaders::CastParameters cast_parameters(const Scene& scene, PictureSize size, const FanGeometry& geometry,
                                        const AngleTable& table, const VolumeExtent& volume);

/// The box around what a volume has scanned.
Box fan_box(const FanGeometry& geometry, const VolumeExtent& volume);

/// The grid of a CutMask. It is the same for all sweeps of a probe, whose angles differ a little.
CutGrid cut_grid(const FanGeometry& geometry, const VolumeExtent& volume);

/// Whether pass 1 skips empty space, and passes 2 and 3 what is as in the last picture. The pictures are the
/// same; kOff serves comparisons.
enum class Skipping : std::uint8_t { kOn, kOff };

/// Whether pass 1 counts the samples that it reads. That has a price: for measurements.
enum class Counting : std::uint8_t { kOff, kOn };

/// The pipelines of pass 1 for a scene and a kind of frames.
struct CastKeys {
  PipelineKey cast;                        ///< rays of all tiles
  std::optional<PipelineKey> empty_space;  ///< runs before the rays; absent where rays sample everything
  std::optional<PipelineKey> frame_steps;  ///< runs after the rays; absent where their depths are kept
  std::optional<PipelineKey> slice;        ///< absent where the mode shows no planes
  std::optional<PipelineKey> cast_listed;  ///< rays of the dirty tiles only; absent as dirty_tiles
  std::optional<PipelineKey> dirty_tiles;  ///< absent unless frames are replaced one by one (Refresh::kFrame)
                                           ///< and rays skip empty space
};
/// `counting`: of whole casts. Then no tiles are cast again where frames are replaced one by one.
CastKeys cast_keys(const Scene& scene, const FanGeometry& geometry, Skipping skipping,
                   Counting counting = Counting::kOff);

/// The pipeline that computes the confidence in each surface of a cast, the weights of pass 2's depth filter.
PipelineKey confidence_key(const Scene& scene, const FanGeometry& geometry);

/// The transfer function by grey level: colour, and the opacity of one sample of `step_mm`.
using TransferTable = std::array<glm::vec4, 256>;
TransferTable transfer_table(const TransferFunction& transfer, double step_mm);

}  // namespace fanlight
