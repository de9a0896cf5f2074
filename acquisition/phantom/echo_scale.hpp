// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace fanlight {

/// From the amplitude of an echo to the grey level of a pixel.
struct EchoScale {
  enum class Kind : std::uint8_t {
    kLog,     ///< in decibels, as scanners show it
    kLinear,  ///< proportional to the amplitude, for the theory of speckle
  };
  Kind kind = Kind::kLog;
  double range_db = 60;  ///< kLog: from grey 0 to grey 255
  double gain_db = 0;    ///< kLog: shifts all grey levels by 255 / range_db for each dB

  /// The amplitude of tissue at its surface; with kLinear its grey level.
  static constexpr double kTissue = 110;

  /// The grey level of an amplitude; may be below 0 or above 255.
  double grey(double amplitude) const;

  /// kLog: what each factor of FrameSpeckle adds to a grey level.
  std::array<std::int16_t, 256> speckle_greys() const;
};

}  // namespace fanlight
