// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "acquisition/phantom/echo_scale.hpp"
#include "acquisition/phantom/speckle_tile.hpp"

namespace fanlight {

/// The simulated probe's echo as a function of depth below the surface: fluid, skin, and tissue that fades
/// with depth.
///
/// Across the thickness of the beam, a slanted surface lies at different depths. Its echo is that of a flat
/// surface, blurred by a Gaussian along depth. So there is a table for each of kBlurs standard deviations.
/// Grey levels are blurred, in kLog too: the faint tails of a blurred power would need the surface farther
/// next to the frame than its slope says.
class EchoModel {
 public:
  static constexpr double kBeforeMm = 14;  ///< a table begins this far before the surface
  static constexpr double kStepMm = 1.0 / 16;
  static constexpr std::uint32_t kBlurs = 14;
  static constexpr double kBlurStepMm = 0.4;

  /// `field_mm`: greatest depth below the surface.
  EchoModel(const EchoScale& scale, double field_mm);

  std::uint32_t entries() const { return entries_; }

  /// Mean grey levels, kBlurs x entries(). They may be below 0 before the speckle is added.
  const std::int16_t* greys() const { return greys_.data(); }

  /// kLog: what a factor of SpeckleTile adds to a grey level.
  const std::array<std::int16_t, 256>& speckle_greys() const { return speckle_greys_; }

 private:
  std::uint32_t entries_;
  std::vector<std::int16_t> greys_;
  std::array<std::int16_t, 256> speckle_greys_{};
};

}  // namespace fanlight
