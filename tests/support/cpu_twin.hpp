#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "proto/scene.hpp"
#include "proto/volume.hpp"
#include "renderer/view.hpp"

/// The passes once more, in plain double precision and without tables, running sums or skipping: one function
/// a pass, to be read beside the design, section 4. For tests alone.
///
/// Every map is height x width of the picture, top row first. Depths are kNoSurface where there is no
/// surface, and outside viewport(scene, size) there is none.
namespace fanlight::test {

using Rgb = glm::dvec3;  ///< red, green, blue, 0 to 1, as displayed (sRGB)

inline constexpr double kNoSurface = -1;

/// Pass 0: the volume with its speckle reduced, its frames, angles and stamps as they were.
Volume twin_prepare(const Scene::Speckle& speckle, const Volume& volume);

struct TwinCast {
  std::vector<double> depth_mm;  ///< nowhere in Mode::kSlice, which casts no rays
  std::vector<double>
      confidence;           ///< steps of the echo at the surface, in standard deviations; 0 without one
  std::vector<Rgb> colour;  ///< of the modes that show the echo itself; black elsewhere
};

/// Pass 1, on what twin_prepare() made.
TwinCast twin_cast(const Scene& scene, PictureSize size, const Volume& prepared);

// Pass 2, the depth map. Each step takes what the one before made.

/// Blends in the last volume's result of this step; `previous_mm` is empty where there is none.
std::vector<double> twin_steady(const Scene::Filter& filter, const std::vector<double>& depth_mm,
                                const std::vector<double>& previous_mm);

/// Takes small surfaces away.
std::vector<double> twin_islands(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm);

/// Fills small holes.
std::vector<double> twin_holes(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm);

/// Smooths: mean, Gaussian or edge preserving. `confidence` is read where it gives the weights.
std::vector<double> twin_filter(const Scene& scene, PictureSize size, const std::vector<double>& depth_mm,
                                const std::vector<double>& confidence);

/// All four in turn.
std::vector<double> twin_depth_filter(const Scene& scene, PictureSize size,
                                      const std::vector<double>& depth_mm, std::vector<double> confidence,
                                      const std::vector<double>& previous_mm);

/// Pass 2, the light: what the mode shows, from the filtered depths and pass 1's colours.
std::vector<Rgb> twin_light(const std::vector<double>& smooth_mm, const std::vector<Rgb>& colour,
                            PictureSize size, const Scene& scene);

/// Pass 3.
std::vector<Rgb> twin_finish(const std::vector<Rgb>& lit, PictureSize size, const Scene::Finish& finish);

}  // namespace fanlight::test
