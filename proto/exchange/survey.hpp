// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/model/scene.hpp"

namespace fanlight {

/// Asks the render thread for a scene that shows the surface of the last volume.
struct SurveyOrder {
  std::uint64_t number = 0;  ///< from 1
  Scene scene;               ///< what is not chosen stays as it is here
};

/// The answer to the newest order.
struct SurveyResult {
  enum class Outcome : std::uint8_t { kNoVolume, kNoMemory, kNoSurface, kFound };
  std::uint64_t number = 0;  ///< of the order
  Outcome outcome = Outcome::kNoVolume;
  Scene scene;                       ///< kFound
  std::vector<std::string> choices;  ///< kFound: a sentence each
};

}  // namespace fanlight
