// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/volume.hpp"

namespace fanlight {

/// Asks the render thread for a copy of the volume that is shown. The memory comes with the order, its pages
/// in use already, so that the render thread allocates nothing; the sender must not touch it before the
/// answer.
struct VolumeOrder {
  std::uint64_t number = 0;  ///< chosen by the sender, returned in the answer
  std::shared_ptr<Volume> into;
};

/// The answer to an order.
struct VolumeAnswer {
  enum class Outcome : std::uint8_t { kNoVolume, kTooSmall, kCopied };
  std::uint64_t number = 0;      ///< of the order
  std::shared_ptr<Volume> into;  ///< of the order: the render thread frees nothing
  Outcome outcome = Outcome::kNoVolume;
  FanGeometry geometry;      ///< kTooSmall: of the volume that is shown
  std::uint32_t frames = 0;  ///< kTooSmall: that its memory holds at most
};

/// The render thread's answer. `shown`: the volume that is shown; null: there is none. Copies all of its
/// frames; allocates nothing.
inline VolumeAnswer answer_to(VolumeOrder order, const Volume* shown) {
  using Outcome = VolumeAnswer::Outcome;
  if (shown == nullptr)
    return {.number = order.number, .into = std::move(order.into), .outcome = Outcome::kNoVolume};
  const bool copied = order.into != nullptr && order.into->copy_from(*shown);
  return {.number = order.number,
          .into = std::move(order.into),
          .outcome = copied ? Outcome::kCopied : Outcome::kTooSmall,
          .geometry = shown->geometry(),
          .frames = shown->frame_capacity()};
}

}  // namespace fanlight
