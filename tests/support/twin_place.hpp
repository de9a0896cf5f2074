// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "proto/model/scene.hpp"

namespace fanlight::test {

/// The echo of a ray's sample, 0 to 1; 0 outside the ray.
using SampleEcho = std::function<double(int index)>;

/// A place in samples of the ray, and the certainty of the surface there, 0 to 1.
struct TwinPlace {
  double position = 0;
  double certainty = 1;
};

/// Pass 1: the certainty of the surface whose edge lies at `position`, in samples of the ray (`certainty_by`
/// in surface_place.h). Absent: it is none.
std::optional<double> twin_certainty(const Scene::Detector& detector, const SampleEcho& value,
                                     double position);

/// Pass 1, SurfacePlace::kLevel: where the echo reaches the level of the tissue, for an edge at `position`,
/// both in samples of the ray (`placed_by_level` in surface_place.h). Absent: it is no surface.
std::optional<TwinPlace> twin_place_by_level(const Scene::Detector& detector, const SampleEcho& value,
                                             double spacing_mm, double position);

}  // namespace fanlight::test
