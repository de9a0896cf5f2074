// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "renderer/vulkan/render_device.hpp"

namespace fanlight {

/// What one size of the work costs: medians, ms.
struct ScalePoint {
  std::string name;   ///< "512 x 512"
  double amount = 0;  ///< of pixels, voxels, frames or views
  std::vector<double> ms;
};

/// How costs grow with one amount, the rest being as in the row r1/paper.
struct ScaleCurve {
  std::string amount;                ///< what grows
  std::vector<std::string> columns;  ///< what was measured, as ScalePoint::ms
  std::vector<ScalePoint> points;
  /// Of each column: b in cost = a * amount^b, by least squares of the logarithms. 1: twice the work takes
  /// twice the time. 0 where a point is 0.
  std::vector<double> exponents;
};

/// Measures all curves, each point with this number of rounds after one that is not counted, and reports each
/// curve when it is done.
Result<void> run_bench_scale(const RenderDevice& device, int rounds,
                             const std::function<void(const ScaleCurve&)>& tell);

/// b of ScaleCurve::exponents.
double scale_exponent(const std::vector<double>& amounts, const std::vector<double>& costs);

}  // namespace fanlight
