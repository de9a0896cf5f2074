// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tests/accuracy/depth_truth.hpp"

namespace fanlight::test {

inline constexpr PictureSize kViewSize{.width = 128, .height = 128};

/// A scene over a known surface, with the truth of each of its pixels.
struct KnownView {
  Scene scene;
  PictureSize size;
  PixelRays rays;
  std::vector<PixelTruth> truth;
};

/// The default scene of a fan, from the probe. The picture is 40 mm high, so that its pixels are as large as
/// those of the reference work (R1).
Scene scene_from_probe(const ScannedFan& fan, Projection projection);

/// A scene with its truth.
KnownView known_view(const Scene& scene, const ScannedFan& fan, const KnownSurface& surface);

/// The view of scene_from_probe().
KnownView view_from_probe(const ScannedFan& fan, const KnownSurface& surface, Projection projection);

/// Two views: from the probe, and oblique, so that neither rays nor pixels are aligned with the samples.
std::vector<KnownView> known_views(const ScannedFan& fan, const KnownSurface& surface, Projection projection);

}  // namespace fanlight::test
