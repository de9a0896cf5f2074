#pragma once

#include <optional>

#include "acquisition/sweep_thumbnails.hpp"

namespace fanlight {

/// By what angle a sweep disagrees with the one before it and the one after it, which both went the other
/// way, in radians: what `middle` shows at angle a, the others show at a + shift. nullopt where they cannot
/// be compared: different geometries, less than half of the angles in common, a difference beyond 4 deg, or
/// too little in the frames that changes with the angle (a standard error above 0.25 deg). Allocates nothing.
///
/// The scene moves between two looks at one place. So the sweeps before and after are first interpolated to
/// the time at which the middle one looked: a steady motion, whatever it is, then takes no part. The shift is
/// where the sum of squared differences is least, found by trial in steps of half a degree and then by
/// Gauss-Newton steps (Lucas and Kanade, "An iterative image registration technique", 1981).
std::optional<double> shift_between(const SweepThumbnails& before, const SweepThumbnails& middle,
                                    const SweepThumbnails& after);

}  // namespace fanlight
