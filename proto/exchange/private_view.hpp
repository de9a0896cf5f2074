// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "proto/base/fixed_text.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// A view of one display in addition to the main view, rendered in the time that the main view leaves.
struct PrivateView {
  std::uint64_t view_id = 0;  ///< 0: this entry is unused
  /// The whole scene, including the fields taken from the main view; its revision counts the changes of this
  /// view.
  NumberedScene scene;
  /// Whether it casts its own rays. Otherwise the depth map of the main view is filtered and lit once more,
  /// and only the fields that passes 2 and 3 read are used.
  bool own_camera = false;
  /// Receives its pictures (newest wins), written by the render thread.
  Mailbox<Picture>* pictures = nullptr;
};

/// Where the main view would take all the time, it takes this multiple of the time of the private views.
inline constexpr std::int64_t kMainTimes = 4;

inline constexpr std::size_t kMostPrivateViews = 4;
using PrivateViews = std::array<PrivateView, kMostPrivateViews>;

/// A private view that the renderer has ended, because its memory, a pipeline or a submission failed. It gets
/// no further picture until its scene has a larger revision.
struct PrivateViewEnd {
  std::uint64_t view_id = 0;   ///< 0: no view of this index has ended yet
  std::uint64_t revision = 0;  ///< of its scene
  FixedText<300> reason;       ///< a sentence
};
/// The last view that ended, for each index of PrivateViews.
using PrivateViewEnds = std::array<PrivateViewEnd, kMostPrivateViews>;

}  // namespace fanlight
