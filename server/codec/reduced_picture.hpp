// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "proto/model/picture.hpp"
#include "proto/model/picture_size.hpp"

namespace fanlight {

/// The view of a picture, for the same picture with `scale` times as many pixels on each side.
PictureView scaled(const PictureView& view, double scale);

/// The depth map of a picture in a smaller size: each pixel has the depth of the one at its centre.
std::vector<float> reduced_depths(const Picture& picture, PictureSize size);

/// A picture in a smaller size of the same proportions. Colours are averaged (PictureScaler), depths and
/// certainties are those of the pixel at the centre.
Picture reduced(const Picture& picture, PictureSize size);

}  // namespace fanlight
