// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

/// Slow oscillation between -amplitude and +amplitude. The phase is in periods.
inline double sway(double amplitude, double period_s, double phase, double time_s) {
  return amplitude * std::sin(2 * kPi * (time_s / period_s + phase));
}

}  // namespace fanlight
