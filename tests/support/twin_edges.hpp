// SPDX-License-Identifier: Apache-2.0
// CPU twin of the detector's window (shaders/edge_detector.h).
#pragma once

#include <cstddef>
#include <vector>

#include "proto/model/scene.hpp"

namespace fanlight::test {

/// The step in each full window of a run: the mean of its newest half - the mean of its oldest half, with the
/// sign of the detector. `advance` in edge_detector.h computes the same as a difference of sums.
std::vector<double> window_heights(const Scene::Detector& detector, const std::vector<double>& run);

struct SteepestWindow {
  double position = 0;  ///< in windows, interpolated by the parabola through the peak and its neighbours
  double height = 0;    ///< of the window itself
};

/// The steepest window of the edge that begins with window `first` (`follow_edge` in edge_detector.h).
SteepestWindow steepest_window(const std::vector<double>& heights, std::size_t first, double threshold);

}  // namespace fanlight::test
