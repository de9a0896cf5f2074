// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "proto/model/picture_size.hpp"
#include "server/stream/outgoing_queue.hpp"

namespace fanlight {

/// What one display may take of the server's time and memory.
struct SessionLimits {
  /// A scene change with every field has under 1 KB, and up to 29 KB of cuts.
  static constexpr std::size_t kMessageBytes = 64 << 10;
  /// Up to this size a message is read to its end, so that the client receives the reason of the refusal.
  /// Beyond it, the connection is cut.
  static constexpr std::size_t kReadBytes = 1 << 20;
  /// Before the login, a client has no other message to send.
  static constexpr std::size_t kLoginBytes = 4 << 10;
  /// More than the Hello has: the table of all scene fields, and two scenes with up to 29 KB of cuts each.
  static constexpr std::size_t kAnswerBytes = 128 << 10;

  /// The last region of fluid that was found for it: 48 cells along each axis.
  static constexpr std::size_t kRegionBytes = 112 << 10;

  int login_s = 10;   ///< until it has logged in
  int stalled_s = 5;  ///< without progress in what is sent, or in closing
  std::chrono::milliseconds unanswered{
      10'000};  ///< without anything from it; half of it until a ping is sent

  /// Memory of a session at most, bytes: a message that it sends, its answers, a region of fluid, one
  /// picture under way and one that waits. Pictures are shared by the displays that ask for the same. PNG and
  /// the depth map are not larger than the pixels.
  static constexpr std::uint64_t most_bytes(PictureSize largest) {
    const std::uint64_t picture = 2 * 4 * largest.pixels();
    return kReadBytes + OutgoingQueue::kMostAnswers * kAnswerBytes + kRegionBytes + 2 * picture;
  }
};

}  // namespace fanlight
