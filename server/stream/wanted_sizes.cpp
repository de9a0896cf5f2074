// SPDX-License-Identifier: Apache-2.0
#include "server/stream/wanted_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fanlight {

namespace {

/// The largest size within the limits of the settings, in the proportions of the usual one.
PictureSize size_within(const StreamSettings& settings, PictureSize usual) {
  if (!settings.has_size()) return usual;
  // A side that is not given does not limit the other.
  const auto factor = [](std::uint32_t most, std::uint32_t side) {
    return most > 0 ? static_cast<double>(most) / side : std::numeric_limits<double>::infinity();
  };
  const double scale =
      std::min(factor(settings.most_width, usual.width), factor(settings.most_height, usual.height));
  return {.width = static_cast<std::uint32_t>(std::lround(scale * usual.width)),
          .height = static_cast<std::uint32_t>(std::lround(scale * usual.height))};
}

}  // namespace

StreamSettings with_size(StreamSettings settings, std::optional<PictureSize> usual) {
  if (settings.has_size() || settings.codec == StreamSettings::Codec::kSurface || !usual) return settings;
  settings.most_width = usual->width;
  settings.most_height = usual->height;
  return settings;
}

void widen(WantedSizes& wanted, const StreamSettings& settings, PictureSize usual) {
  const bool lights = settings.codec == StreamSettings::Codec::kSurface;
  std::optional<PictureSize>& largest = lights ? wanted.of_surfaces : wanted.of_pictures;
  const PictureSize size = size_within(settings, usual);
  if (size.height > largest.value_or(usual).height) largest = size;
}

}  // namespace fanlight
