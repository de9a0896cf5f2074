// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/model/echo_levels.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// The levels of one volume: from some ten thousand blocks of pixels, which the method of Otsu (1979, "A
/// threshold selection method from gray-level histograms") parts into dark and bright ones. Medians, so that
/// blocks on an edge do not count. Layers below the probe's face that are bright all over, as by
/// reverberation, do not count either. Reads less than a million pixels; does not allocate.
EchoLevels measured_levels(const Volume& volume);

/// Levels that are steady over volumes: a slow mean, and what is in force follows it in steps of a tenth. A
/// change by half, as of another gain or another recording, is in force at once, and so are volumes without
/// contrast, after three in a row.
class SteadyLevels {
 public:
  const EchoLevels& in_force() const { return in_force_; }
  void add(const EchoLevels& measured);

  /// Whether add() would put these in force at once: the first ones, or a change by half.
  bool is_other(const EchoLevels& measured) const;

 private:
  EchoLevels mean_;
  EchoLevels in_force_;
  std::uint32_t flat_volumes_ = 0;  // in a row
};

}  // namespace fanlight
