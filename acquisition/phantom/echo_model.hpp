// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "acquisition/phantom/echo_scale.hpp"

namespace fanlight {

/// The simulated probe's echo as a function of depth below the surface: fluid, skin, and tissue that fades
/// with depth.
///
/// Across the thickness of the beam, a slanted surface lies at different depths. The power of its echo is
/// that of a flat surface, blurred by a Gaussian along depth, before the compression. So there is a table for
/// each of kBlurs standard deviations, each with the length of the pulse (BeamEcho). It takes the surface for
/// a plane as far as the beam reaches.
class EchoModel {
 public:
  static constexpr double kBeforeMm = 17;  ///< a table begins this far before the surface
  static constexpr double kStepMm = 1.0 / 16;
  static constexpr std::uint32_t kBlurs = 14;
  static constexpr double kBlurStepMm = 0.4;

  /// `field_mm`: greatest depth below the surface.
  EchoModel(const EchoScale& scale, double field_mm);

  std::uint32_t entries() const { return entries_; }

  /// Mean grey levels, kBlurs x entries(). They may be below 0 before the speckle is added.
  const std::int16_t* greys() const { return greys_.data(); }

  /// kLog: what a factor of FrameSpeckle adds to a grey level.
  const std::array<std::int16_t, 256>& speckle_greys() const { return speckle_greys_; }

 private:
  std::uint32_t entries_;
  std::vector<std::int16_t> greys_;
  std::array<std::int16_t, 256> speckle_greys_{};
};

}  // namespace fanlight
