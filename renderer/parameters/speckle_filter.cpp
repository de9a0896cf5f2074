// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/speckle_filter.hpp"

namespace fanlight {

namespace {

/// The guided filter takes a mean of means, so it reaches over two radii.
int reach(SpeckleFilter filter, int radius) {
  switch (filter) {
    case SpeckleFilter::kNone:
      return 0;
    case SpeckleFilter::kGuided:
      return 2 * radius;
    default:
      return radius;
  }
}

}  // namespace

SpeckleKeys::SpeckleKeys(const Scene::Speckle& speckle, bool masked) {
  const std::int32_t mask = masked ? 1 : 0;
  const auto add = [&](Shader shader) {
    keys_[count_++] = {.shader = shader, .constants = {speckle.size, mask}};
  };
  switch (speckle.filter) {
    case SpeckleFilter::kNone:
      break;
    case SpeckleFilter::kBox:
      add(Shader::kBox);
      break;
    case SpeckleFilter::kMedian:
      keys_[count_++] = {.shader = Shader::kMedian, .constants = {speckle.size, speckle.across, mask}};
      break;
    case SpeckleFilter::kGuided:
      add(Shader::kGuidedFit);
      add(Shader::kGuidedApply);
      break;
  }
}

int speckle_reach_pixels(const Scene::Speckle& speckle) {
  return reach(speckle.filter, speckle.size / 2);
}

std::uint32_t speckle_reach_frames(const Scene::Speckle& speckle) {
  return static_cast<std::uint32_t>(reach(speckle.filter, speckle.across / 2));
}

}  // namespace fanlight
