#pragma once

#include <cstdint>
#include <vector>

#include "tests/support/known_surface.hpp"
#include "tests/support/pixel_rays.hpp"
#include "tests/support/scanned_fan.hpp"

namespace fanlight::test {

/// What the ray of a pixel meets.
enum class Meets : std::uint8_t {
  kNothing,      ///< it misses the fan
  kFluid,        ///< fluid alone: any surface shown is false
  kSurface,      ///< the surface, well inside the fan
  kBorder,       ///< the surface, but too near the fan's border for the detector's window: not judged
  kTissueFirst,  ///< it enters the fan within tissue and meets no surface: the cut side of the tissue
};

struct PixelTruth {
  Meets meets = Meets::kNothing;
  double depth_mm = 0;       ///< of the surface
  double incidence_deg = 0;  ///< between the ray and the surface's normal
};

/// Surfaces nearer to the fan's border than this are kBorder: half the largest window judged (28 samples of
/// 0.31 mm), a sample for the refined place, and some.
inline constexpr double kBorderMm = 5;

/// The truth of each pixel of a picture, row by row.
std::vector<PixelTruth> depth_truth(const PixelRays& rays, PictureSize size, const ScannedFan& fan,
                                    const KnownSurface& surface);

}  // namespace fanlight::test
