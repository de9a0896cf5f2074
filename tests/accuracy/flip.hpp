// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "renderer/parameters/view_frame.hpp"

namespace fanlight::test {

/// How different two pictures look to an observer who flips between them, at each pixel: 0, the same, to 1.
/// Andersson et al., "FLIP: a difference evaluator for alternating images" (2020), for pictures of low
/// dynamic range, with its constants. Colours: sRGB, 0 to 1. Maps: height x width, top row first.
/// `pixels_per_degree`: of the observer's field of view; 67 is the paper's screen, 0.7 m wide and 3840 pixels
/// at 0.7 m.
std::vector<double> flip_errors(std::span<const glm::dvec3> reference, std::span<const glm::dvec3> shown,
                                PictureSize size, double pixels_per_degree = 67);

}  // namespace fanlight::test
