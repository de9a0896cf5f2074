// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/parameters/view_frame.hpp"

namespace fanlight::test {

/// Structural similarity of two pictures of brightnesses from 0 to 1, at each pixel: Wang et al., "Image
/// quality assessment: from error visibility to structural similarity" (2004), with its window, a Gaussian of
/// 1.5 pixels within 11 x 11, and its constants 0.01 and 0.03. Maps: height x width, top row first.
std::vector<double> structural_similarity(std::span<const double> a, std::span<const double> b,
                                          PictureSize size);

/// The border of a part of a picture, which a map of 0 and 1 marks.
struct Outline {
  double mean_distance_pixels = 0;  ///< from each pixel of the shown border to the nearest of the true one
  double length_ratio = 0;          ///< of the shown border over the true one, in sides of pixels
};
Outline compared_outlines(std::span<const std::uint8_t> shown, std::span<const std::uint8_t> truth,
                          PictureSize size);

}  // namespace fanlight::test
