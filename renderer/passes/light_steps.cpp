// SPDX-License-Identifier: Apache-2.0
#include "renderer/passes/light_steps.hpp"

#include <algorithm>
#include <span>

namespace fanlight {

std::size_t LightSteps::count_of(Stage stage) const {
  return static_cast<std::size_t>(
      std::ranges::count(std::span(steps_).first(count_), stage, &LightStep::stage));
}

std::size_t LightSteps::index_of(Stage stage) const {
  std::size_t index = 0;
  while (index < count_ && steps_.at(index).stage < stage) ++index;
  return index;
}

std::size_t LightSteps::end_of_piece(double step_ms, double most_ms) const {
  const Stage stage = steps_.at(next_).stage;
  double piece_ms = step_ms;
  std::size_t end = next_ + 1;
  while (end < count_ && steps_.at(end).stage == stage && piece_ms + step_ms <= most_ms) {
    piece_ms += step_ms;
    ++end;
  }
  return end;
}

}  // namespace fanlight
