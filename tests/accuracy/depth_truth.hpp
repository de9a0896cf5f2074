// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "tests/support/known_surface.hpp"
#include "tests/support/pixel_rays.hpp"
#include "tests/support/scanned_fan.hpp"

namespace fanlight::test {

/// The first structure on the ray of a pixel.
enum class Meets : std::uint8_t {
  kNothing,      ///< the ray misses the fan
  kFluid,        ///< fluid only: any rendered surface is false
  kSurface,      ///< the surface, at least kBorderMm inside the fan
  kBorder,       ///< the surface, too near the border of the fan for the detector's window: not judged
  kTissueFirst,  ///< the ray enters the fan in tissue, through its cut side, and meets no surface
};

struct PixelTruth {
  Meets meets = Meets::kNothing;
  double depth_mm = 0;       ///< of the surface
  double incidence_deg = 0;  ///< between the ray and the surface's normal
};

/// Surfaces nearer to the border of the fan than this are kBorder: half of the largest window in use (28
/// samples of 0.31 mm), one sample for the refined position, and a margin.
inline constexpr double kBorderMm = 5;

/// The truth of each pixel of a picture, height x width, top row first.
std::vector<PixelTruth> depth_truth(const PixelRays& rays, PictureSize size, const ScannedFan& fan,
                                    const KnownSurface& surface);

}  // namespace fanlight::test
