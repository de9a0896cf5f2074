// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/echo_model.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "acquisition/phantom/beam_echo.hpp"

namespace fanlight {

namespace {

/// Amplitudes in units of a linear pixel.
struct Tissue {
  double fluid = 0;
  double tissue = 0;  // at the surface
  double skin = 0;    // added to the tissue's
};
constexpr Tissue kLinearTissue{.fluid = 6, .tissue = EchoScale::kTissue, .skin = 70};
// Fluid is 34 dB below tissue, and the skin 10 dB above it.
constexpr Tissue kLogTissue{.fluid = 2.2, .tissue = EchoScale::kTissue, .skin = 238};

constexpr double kSkinMm = 0.9;        // standard deviation: a bright band of 1 to 2 mm
constexpr double kDecayMm = 70;        // depth over which the tissue's amplitude falls to 1/e
constexpr double kInterfaceMm = 0.25;  // half width of the step at the surface, less than a pixel

std::int16_t rounded(double grey) {
  return static_cast<std::int16_t>(std::lround(std::clamp(grey, -1000.0, 1000.0)));
}

/// The power of the echo for each depth.
std::vector<double> flat_echo(const Tissue& of, std::uint32_t entries) {
  std::vector<double> power(entries);
  for (std::size_t i = 0; i < power.size(); ++i) {
    const double depth_mm = (static_cast<double>(i) + 0.5) * EchoModel::kStepMm - EchoModel::kBeforeMm;
    const double in_skin = depth_mm / kSkinMm;
    const double tissue = of.tissue * std::exp(-std::max(depth_mm, 0.0) / kDecayMm) +
                          of.skin * std::exp(-0.5 * in_skin * in_skin);
    const double share = std::clamp(0.5 + 0.5 * depth_mm / kInterfaceMm, 0.0, 1.0);
    const double amplitude = of.fluid + share * (tissue - of.fluid);
    power[i] = amplitude * amplitude;
  }
  return power;
}

std::vector<double> blurred(const std::vector<double>& values, std::uint32_t blur) {
  const auto last = static_cast<std::int64_t>(values.size()) - 1;
  const double deviation =
      std::hypot(blur * EchoModel::kBlurStepMm, BeamEcho::kPulseMm) / EchoModel::kStepMm;  // in entries
  const auto reach = static_cast<std::int64_t>(std::ceil(3 * deviation));
  std::vector<double> weights;
  for (std::int64_t away = -reach; away <= reach; ++away) {
    const double share = static_cast<double>(away) / deviation;
    weights.push_back(std::exp(-0.5 * share * share));
  }
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<double> result;
  for (std::int64_t i = 0; i <= last; ++i) {
    double sum = 0;
    for (std::int64_t away = -reach; away <= reach; ++away) {
      sum += weights[away + reach] * values[std::clamp<std::int64_t>(i + away, 0, last)];
    }
    result.push_back(sum / all);
  }
  return result;
}

}  // namespace

EchoModel::EchoModel(const EchoScale& scale, double field_mm)
    : entries_(static_cast<std::uint32_t>((kBeforeMm + field_mm) / kStepMm)),
      speckle_greys_(scale.speckle_greys()) {
  const bool log = scale.kind == EchoScale::Kind::kLog;
  const Tissue& of = log ? kLogTissue : kLinearTissue;
  const std::vector<double> flat = flat_echo(of, entries_);
  greys_.reserve(std::size_t{kBlurs} * entries_);
  for (std::uint32_t blur = 0; blur < kBlurs; ++blur) {
    std::ranges::transform(blurred(flat, blur), std::back_inserter(greys_),
                           [&](double power) { return rounded(scale.grey(std::sqrt(power))); });
  }
}

}  // namespace fanlight
