// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "proto/model/scene.hpp"
#include "renderer/parameters/pipeline_key.hpp"

namespace fanlight {

/// The pipelines of pass 0's speckle filter, in the order in which they run. Empty without a filter; the
/// guided filter has two halves.
class SpeckleKeys {
 public:
  /// `masked`: FanGeometry::zero_is_unscanned.
  SpeckleKeys(const Scene::Speckle& speckle, bool masked);
  std::span<const PipelineKey> keys() const { return std::span(keys_).first(count_); }

 private:
  std::array<PipelineKey, 2> keys_;
  std::size_t count_ = 0;
};

/// Distance, in pixels of a frame, over which pass 0 mixes pixels.
int speckle_reach_pixels(const Scene::Speckle& speckle);

/// Distance, in frames, over which pass 0 mixes frames.
std::uint32_t speckle_reach_frames(const Scene::Speckle& speckle);

}  // namespace fanlight
