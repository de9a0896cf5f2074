// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace fanlight {

/// The greatest grey value of a frame: shaders work on 0 to 1, the scene on 0 to 255.
constexpr double kGreyLevels = 255;

}  // namespace fanlight
