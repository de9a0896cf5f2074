// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <vector>

namespace fanlight {

/// The points across a ray whose mean is a sample with rays.window `window`, odd: in steps of the ray to the
/// right and up. Three on each of (window - 1) / 2 rings have the centre and the spread of a grid of window x
/// window points a step apart. Without points, which window 1 has, the sample is that of the ray itself.
std::vector<glm::dvec2> points_across(int window);

}  // namespace fanlight
