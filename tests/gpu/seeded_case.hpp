#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "proto/fan_geometry.hpp"
#include "proto/scene.hpp"
#include "renderer/view.hpp"

namespace fanlight::test {

/// Something to render and a way to see it, with every option of the scene drawn from the seed.
struct SeededCase {
  std::uint32_t seed = 0;
  FanGeometry geometry;
  std::vector<double> angles_rad;  ///< in order of arrival: forward, backward or out of order
  PictureSize size;                ///< mostly no multiple of a work group
  Scene scene;
  std::function<double(const Point&)> grey;        ///< 0 to 255, for made_volume()
  std::function<double(const Point&)> moved_grey;  ///< the same a little later
};

/// A small fan over an undulating surface in fluid, some with a ledge, with crumbs before the surface and
/// pits in it for the filters, and with noise. Edges are soft, so that no ray decides by rounding whether it
/// hits.
SeededCase seeded_case(std::uint32_t seed);

}  // namespace fanlight::test
