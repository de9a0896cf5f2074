// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/base/fixed_text.hpp"

namespace fanlight {

/// Whether the renderer can make pictures. The render thread sends it when it changes; the server notifies
/// displays. Copies allocate nothing.
struct RenderHealth {
  enum class State : std::uint8_t {
    kRunning,
    kSlow,      ///< the GPU works on one submission for longer than usual, and still answers
    kHung,      ///< the GPU does not finish a submission; the device is about to be reopened
    kRemaking,  ///< the device was lost or did not answer, and is being reopened
  };
  State state = State::kRunning;
  std::int64_t since_ns = 0;       ///< fanlight::now_ns of the last change of `state`
  std::uint64_t devices_lost = 0;  ///< since the start
  FixedText<500> cause;            ///< a sentence, where `state` is not kRunning
  FixedText<500> refusal;          ///< why the newest volume or scene was refused; empty: both were taken
};

}  // namespace fanlight
