#pragma once

#include <vector>

#include "tests/accuracy/depth_truth.hpp"

namespace fanlight::test {

inline constexpr PictureSize kViewSize{.width = 128, .height = 128};

/// A picture of a known surface, before it is rendered.
struct KnownView {
  Scene scene;
  PictureSize size;
  PixelRays rays;
  std::vector<PixelTruth> truth;
};

/// The default scene of a fan, and the same from elsewhere: from the probe, and obliquely so that neither
/// rays nor pixels run along the samples. The picture is 40 mm high, so that its pixels are as large as those
/// of the reference work (R1).
std::vector<KnownView> known_views(const ScannedFan& fan, const KnownSurface& surface, Projection projection);

}  // namespace fanlight::test
