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

SpeckleKeys::SpeckleKeys(const Scene::Speckle& speckle) {
  const auto add = [&](Shader shader, std::int32_t across) {
    keys_[count_++] = {.shader = shader, .constants = {speckle.size, across}};
  };
  switch (speckle.filter) {
    case SpeckleFilter::kNone:
      break;
    case SpeckleFilter::kBox:
      add(Shader::kBox, 0);
      break;
    case SpeckleFilter::kMedian:
      add(Shader::kMedian, speckle.across);
      break;
    case SpeckleFilter::kGuided:
      add(Shader::kGuidedFit, 0);
      add(Shader::kGuidedApply, 0);
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
