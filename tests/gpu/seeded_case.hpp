// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/view_frame.hpp"

namespace fanlight::test {

/// A volume and a scene, with every option of the scene drawn from the seed.
struct SeededCase {
  std::uint32_t seed = 0;
  FanGeometry geometry;
  std::vector<double> angles_rad;  ///< in order of capture: forward, backward or out of order
  PictureSize size;                ///< mostly not a multiple of a work group's size
  Scene scene;
  std::function<double(const Point&)> grey;        ///< 0 to 255, for made_volume()
  std::function<double(const Point&)> moved_grey;  ///< the same tissue a little later
};

/// A small fan over an undulating surface in fluid; some cases have a ledge, small balls in front of the
/// surface and pits in it for the filters, and noise. Edges are smooth, so that rounding does not decide
/// whether a ray hits.
SeededCase seeded_case(std::uint32_t seed);

}  // namespace fanlight::test
