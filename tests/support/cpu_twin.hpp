// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/view_frame.hpp"

/// A second implementation of all passes on the CPU, for tests only: double precision, without tables,
/// running sums or skipping. One function a pass; see renderer/ALGORITHM.md.
///
/// Every map is height x width of the picture, top row first. Depths are mm below the view plane, kNoSurface
/// without a surface. There is no surface outside viewport(scene, size).
namespace fanlight::test {

using Rgb = glm::dvec3;  ///< red, green, blue, 0 to 1, as displayed (sRGB)

inline constexpr double kNoSurface = -1;

/// Pass 0: the volume with reduced speckle. The order of frames, the angles and the stamp are unchanged.
Volume twin_prepare(const Scene::Speckle& speckle, const Volume& volume);

struct TwinCast {
  std::vector<double> depth_mm;    ///< no surfaces in Mode::kSlice, which casts no rays
  std::vector<double> confidence;  ///< contrast of the edge over the noise next to it; 0 without a surface
  std::vector<double> certainty;   ///< 0 to 1 by the contrast of fluid and tissue; -1 without a surface
  std::vector<Rgb> colour;         ///< in the modes that show the echo itself; black in the others
};

/// Pass 1, FrameSteps::kRemoved: the mean of `ray_mm`, where rays met the surface, over one frame spacing,
/// across the frames. Crop and clip planes do not bound it.
std::vector<double> twin_frame_steps(const Scene& scene, PictureSize size, const Volume& prepared,
                                     const std::vector<double>& ray_mm);

/// Pass 1, from the result of twin_prepare().
TwinCast twin_cast(const Scene& scene, PictureSize size, const Volume& prepared);

// Pass 2, the depth map. Each step takes the result of the previous step.

/// Removes small surfaces.
std::vector<double> twin_islands(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm);

/// Fills small holes.
std::vector<double> twin_holes(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm);

/// The depth filter: mean, Gaussian or edge-preserving. `confidence` is used if the weights depend on it.
std::vector<double> twin_filter(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm,
                                const std::vector<double>& confidence);

/// These three in turn, after the temporal filter (twin_steady.hpp).
std::vector<double> twin_depth_filter(const Scene& scene, PictureSize size,
                                      const std::vector<double>& steady_mm, std::vector<double> confidence);

/// Pass 2, light: the picture of the mode, from the filtered depths, their certainty, and the colours of
/// pass 1.
std::vector<Rgb> twin_light(const std::vector<double>& smooth_mm, const std::vector<double>& certainty,
                            const std::vector<Rgb>& colour, PictureSize size, const Scene& scene);

/// Pass 3: the outlines of the surfaces of the filtered depths, by coverage.
std::vector<Rgb> twin_outline(const std::vector<Rgb>& lit, const std::vector<double>& smooth_mm,
                              PictureSize size, const Scene& scene);

/// Pass 3: smoothing and colour map.
std::vector<Rgb> twin_finish(const std::vector<Rgb>& lit, PictureSize size, const Scene::Finish& finish);

}  // namespace fanlight::test
