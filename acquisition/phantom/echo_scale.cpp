// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/echo_scale.hpp"

#include <algorithm>
#include <cmath>

#include "acquisition/phantom/frame_speckle.hpp"

namespace fanlight {

namespace {

// Level of tissue below that of grey 255: grey 150 where the range is 60 dB.
constexpr double kHeadroomDb = 24.7;
constexpr double kWhite = 255;

double decibels(double amplitude_ratio) {
  return 20 * std::log10(std::max(amplitude_ratio, 1e-6));
}

}  // namespace

double EchoScale::grey(double amplitude) const {
  if (kind == Kind::kLinear) return amplitude;
  return kWhite + kWhite / range_db * (decibels(amplitude / kTissue) - kHeadroomDb + gain_db);
}

std::array<std::int16_t, 256> EchoScale::speckle_greys() const {
  std::array<std::int16_t, 256> greys{};
  for (std::size_t factor = 0; factor < greys.size(); ++factor) {
    const double ratio = std::max(static_cast<double>(factor), 0.5) / FrameSpeckle::kOne;
    greys[factor] = static_cast<std::int16_t>(std::lround(kWhite / range_db * decibels(ratio)));
  }
  return greys;
}

}  // namespace fanlight
