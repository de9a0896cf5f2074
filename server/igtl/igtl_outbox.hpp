// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <utility>

#include "server/igtl/stream_message.hpp"
#include "server/state/server_counters.hpp"

namespace fanlight {

/// The messages of streams that wait to be sent to one client, and their accounting. Of each stream one
/// waits, and a newer one replaces it. What would be too much memory for all clients together is lost. Two
/// streams differ:
/// - Frames queue, since a sweep needs all of them; newer ones are lost beyond a limit.
/// - A picture of the video may need those before it. If one waits already, the new one is lost, and so are
///   those after it, up to the next key picture, which replaces what waits.
/// Server thread only.
class IgtlOutbox {
 public:
  static constexpr std::size_t kMostFrameBytes = 32 << 20;  ///< a third of a second at 100 MB/s
  static constexpr std::size_t kMostBytesOfAll = 512 << 20;

  /// Both must outlive this object. `bytes_of_all`: of the messages that wait or are being sent, of all
  /// outboxes.
  IgtlOutbox(ServerCounters& counters, std::size_t& bytes_of_all)
      : counters_(counters), bytes_of_all_(bytes_of_all) {}

  /// True if the message waits now. `key`: of the video, a picture that needs none before it.
  bool offer(IgtlStream stream, const IgtlMessage& message, bool key);

  /// The message to send next, from one stream after the other; null: none waits. Its memory counts until
  /// sent().
  IgtlMessage next();
  void sent() { bytes_of_all_ -= std::exchange(bytes_under_way_, 0); }

  /// The client was not sent the newest pictures of the video: it needs a key picture.
  void video_lost() { video_lost_ = true; }
  bool needs_key_picture() const { return video_lost_; }

  /// Drops all that waits.
  void clear();

 private:
  bool offer_frame(const IgtlMessage& message);
  bool can_be_decoded(bool key);
  bool has_room(std::size_t bytes) const { return bytes_of_all_ + bytes <= kMostBytesOfAll; }
  bool lost();

  ServerCounters& counters_;
  std::size_t& bytes_of_all_;
  std::array<IgtlMessage, kIgtlStreams> waiting_;
  std::deque<IgtlMessage> frames_;
  std::size_t frame_bytes_ = 0;      // of those
  std::size_t bytes_under_way_ = 0;  // of the message of next()
  std::size_t turn_ = 0;             // which stream is next
  bool video_lost_ = true;           // before the first one
};

}  // namespace fanlight
