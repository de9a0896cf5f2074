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
  FixedText<500> volume_refusal;   ///< why the newest volume was refused; empty: it was taken
  FixedText<500> scene_refusal;    ///< why the newest scene is not drawn; empty: it is, or was not tried yet
  std::uint64_t refused_revision = 0;  ///< of that scene; 0: none
  bool filter_left_out = false;        ///< the volume shown lacks its speckle filter, for lack of memory
};

}  // namespace fanlight
