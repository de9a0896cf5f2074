#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/scene.hpp"
#include "proto/volume.hpp"
#include "renderer/view.hpp"

/// The passes once more, in plain double precision and without tables, running sums or skipping: one function
/// a pass, to be read beside the design, section 4. For tests alone.
namespace fanlight::test {

using Rgb = std::array<double, 3>;  ///< 0 to 1

inline constexpr double kNoSurface = -1;

struct TwinCast {
  std::vector<double> depth_mm;  ///< height x width, kNoSurface where there is none
  std::vector<Rgb> colour;       ///< of the composited volume; black unless the mode is volume
};

/// Pass 1.
TwinCast twin_cast(const Scene& scene, PictureSize size, const Volume& volume);

/// Pass 2, the moving average: each pixel with a surface becomes the mean over those in its window that have
/// one.
std::vector<double> twin_filter(const std::vector<double>& depth_mm, PictureSize size, int filter_size);

/// Pass 2, normals, light and shadow: sRGB values.
std::vector<Rgb> twin_light(const std::vector<double>& smooth_mm, PictureSize size, const Scene& scene);

/// Pass 3.
std::vector<Rgb> twin_finish(const std::vector<Rgb>& lit, PictureSize size, Finish finish);

}  // namespace fanlight::test
