// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "server/state/notice.hpp"
#include "server/state/server_counters.hpp"
#include "server/stream/picture_subscriber.hpp"

namespace fanlight {

/// What a session sends next, and what it skips. In this order: answers, the close frame, notices, the newest
/// picture. Of each notice, and of pictures, only the newest waits; a picture that is replaced unsent is
/// counted as skipped. Pure logic: no socket, no time. One thread.
class OutgoingQueue {
 public:
  /// A client wants to know which picture is the first to show its change.
  struct ShownRequest {
    std::uint64_t view_id = 0;   ///< 0: the main view
    std::uint64_t revision = 0;  ///< of the scene with the change
    std::uint64_t request_id = 0;
  };

  /// What to send next.
  struct Item {
    enum class Kind : std::uint8_t {
      kNothing,
      kAnswer,    ///< `message`
      kClose,     ///< the close frame; nothing follows it
      kNotice,    ///< the newest value of `notice`
      kShown,     ///< that `picture_id` is the first picture to show `shown`; 0: none is named
      kPicture,   ///< `message`; ends with sent() or end()
      kNeedsKey,  ///< nothing, but the client waits for a key picture
    };
    Kind kind = Kind::kNothing;
    SharedMessage message;
    Notice notice = Notice::kControl;
    ShownRequest shown;
    std::uint64_t picture_id = 0;
  };

  /// Of this session: offered = sent + skipped + the one that waits + the one under way.
  struct PictureCounts {
    std::uint64_t offered = 0;
    std::uint64_t sent = 0;
    std::uint64_t skipped = 0;
  };

  /// `counters` also counts the pictures of all sessions; it must outlive the queue.
  explicit OutgoingQueue(ServerCounters& counters) : counters_(counters) {}

  /// Whether there is room for the answer to another message. The caller stops reading while there is none.
  bool has_room() const { return answers_.size() + given_up_.size() < kMostAnswers; }
  void add_answer(SharedMessage message) { answers_.push_back(std::move(message)); }

  void add_notice(Notice notice) { notices_due_ |= bit(notice); }

  /// At most kMostShownRequests wait; beyond that, the oldest one is answered at once, with picture_id 0: no
  /// picture is named for it.
  void add_shown_request(const ShownRequest& request);

  /// After the answers comes the close frame, and then nothing.
  void close() { closing_ = true; }

  /// Replaces the picture that waits. After a skipped picture only a key picture is taken.
  void offer(const PictureOffer& picture);

  /// The following pictures belong to another stream: skips the one that waits, and sends the next surface
  /// whole. `needs_key`: the stream can only be joined with a key picture.
  void begin_stream(bool needs_key);

  /// Removes and returns what to send next. Precondition: nothing is under way.
  Item next();

  /// What next() returned last was sent.
  void sent();

  /// Nothing more will be sent: skips the pictures that wait or are under way.
  void end();

  const PictureCounts& picture_counts() const { return counts_; }

  static constexpr std::size_t kMostAnswers = 16;
  static constexpr std::size_t kMostShownRequests = 16;

 private:
  static constexpr unsigned bit(Notice notice) { return 1U << static_cast<unsigned>(notice); }
  void skip_waiting();
  void count_skip();
  std::optional<Notice> take_notice();
  Item next_of_picture();

  ServerCounters& counters_;
  std::deque<SharedMessage> answers_;
  unsigned notices_due_ = 0;  // a bit for each Notice
  std::deque<ShownRequest> shown_requests_;
  std::deque<ShownRequest> given_up_;  // to be answered with picture_id 0
  PictureOffer waiting_;               // without a message: none
  bool picture_under_way_ = false;
  std::size_t bytes_under_way_ = 0;   // of that picture
  std::uint64_t client_surface_ = 0;  // PictureOffer::surface_id that the client got last; 0: none
  bool needs_key_ = false;            // a picture was skipped that the next ones may depend on
  bool closing_ = false;
  bool close_sent_ = false;
  PictureCounts counts_;
};

}  // namespace fanlight
