// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "proto/model/echo_levels.hpp"
#include "renderer/survey/echo_grid.hpp"

namespace fanlight {

/// The ratio of two amplitudes that are so many decibels apart.
double amplitude_ratio(double decibels);

/// From the grey levels of log-compressed frames to amplitudes of the echo, in any unit. How many grey levels
/// a decibel has, the speckle says; without log compression, or without speckle, a grey level is an
/// amplitude.
class EchoAmplitude {
 public:
  explicit EchoAmplitude(const EchoLevels& levels);

  double of(double grey) const;
  double grey(double amplitude) const;

  /// Replaces the levels of a grid, 0 to 255, by their amplitudes; by 12 dB over tissue at most, so that a
  /// reflector decides no mean.
  void replace(EchoGrid& grid) const;

 private:
  double levels_per_db_ = 0;  // 0: grey levels are amplitudes
  double most_ = std::numeric_limits<double>::infinity();
};

}  // namespace fanlight
