// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// Whether all lines of all frames of a volume show the same echoes, which depend on the depth alone: the
/// rings of a probe in air, whose pulse comes back from its own lens, brightest next to it. A body shows
/// itself at other depths in other lines, and a plate in a bath is brightest at its own depth. In
/// scan-converted frames the lines are those of the sector. Allocates in the constructor only. One thread.
class RingCheck {
 public:
  RingCheck();

  bool shows_rings(const Volume& volume);

 private:
  void place_lines(const FanGeometry& geometry);

  std::optional<FanGeometry> geometry_;  // that the places are of
  std::vector<std::uint32_t> places_;  // of the samples in a frame: lines x rows x samples beside each other
  std::vector<float> profiles_;        // frames x lines x rows
  std::vector<float> mean_;            // rows
};

}  // namespace fanlight
