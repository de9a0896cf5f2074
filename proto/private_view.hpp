#pragma once

#include <array>
#include <cstdint>

#include "proto/mailbox.hpp"
#include "proto/picture.hpp"
#include "proto/scene.hpp"

namespace fanlight {

/// A view that one display has beside the main one, drawn in the time that the main one leaves.
struct PrivateView {
  std::uint64_t view_id = 0;  ///< 0: none is wanted here
  /// All of it, with what is the main view's; its revision counts the changes of this view.
  NumberedScene scene;
  /// Whether its rays are its own; else the main view's depth map is filtered and lit once more, and of the
  /// scene only what passes 2 and 3 read counts.
  bool own_camera = false;
  /// Where its pictures go, the newest wins; the render thread writes.
  Mailbox<Picture>* pictures = nullptr;
};

inline constexpr std::size_t kMostPrivateViews = 4;
using PrivateViews = std::array<PrivateView, kMostPrivateViews>;

}  // namespace fanlight
