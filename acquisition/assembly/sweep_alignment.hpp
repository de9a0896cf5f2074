// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "acquisition/assembly/sweep_thumbnails.hpp"

namespace fanlight {

/// Angle, in radians, by which a sweep disagrees with the sweeps before and after it, which have the other
/// direction: the image of `middle` at angle a appears in the others at a + shift. nullopt where they cannot
/// be compared: different geometries, less than half of the angles in common, a shift beyond 4 deg, or too
/// little change with the angle (standard error above 0.25 deg). Allocates nothing.
///
/// The scene moves between two looks at the same position. Therefore the sweeps before and after are
/// interpolated to the time at which the middle one looked there; a steady motion then cancels. The shift is
/// the minimum of the sum of squared differences, found by trial in steps of half a degree and refined by
/// Gauss-Newton steps (Lucas and Kanade, "An iterative image registration technique", 1981).
std::optional<double> shift_between(const SweepThumbnails& before, const SweepThumbnails& middle,
                                    const SweepThumbnails& after);

}  // namespace fanlight
