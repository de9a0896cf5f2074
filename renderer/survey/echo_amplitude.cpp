// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/echo_amplitude.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace fanlight {

double amplitude_ratio(double decibels) {
  return std::pow(10, decibels / 20);
}

EchoAmplitude::EchoAmplitude(const EchoLevels& levels) {
  // Speckle that a scanner has smoothed says little: as in EchoLevels::rise(), no contrast is larger.
  constexpr double kMostContrastDb = 50;
  constexpr double kMostRangeDb = 100;  // from black to white, of any scanner
  constexpr double kLeastNoise = 1;     // as EchoLevels::in_decibels()
  if (levels.noise >= kLeastNoise && !levels.linear())
    levels_per_db_ = std::max(
        {levels.levels_per_db(), (levels.tissue - levels.fluid) / kMostContrastDb, 255 / kMostRangeDb});
  constexpr double kMostOverTissueDb = 12;
  if (levels.known) most_ = of(levels.tissue) * amplitude_ratio(kMostOverTissueDb);
}

double EchoAmplitude::of(double grey) const {
  return levels_per_db_ > 0 ? amplitude_ratio(grey / levels_per_db_) : grey;
}

double EchoAmplitude::grey(double amplitude) const {
  constexpr double kLeast = 1e-6;
  return levels_per_db_ > 0 ? 20 * levels_per_db_ * std::log10(std::max(amplitude, kLeast)) : amplitude;
}

void EchoAmplitude::replace(EchoGrid& grid) const {
  std::array<float, 256> table{};
  for (std::size_t grey = 0; grey < table.size(); ++grey)
    table[grey] = static_cast<float>(std::min(of(static_cast<double>(grey)), most_));
  for (float& level : grid.levels) level = table[static_cast<std::size_t>(std::lround(level))];
}

}  // namespace fanlight
