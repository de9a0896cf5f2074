#pragma once

#include <map>
#include <memory>
#include <string>
#include <unordered_set>

#include "proto/picture.hpp"
#include "server/picture_coder.hpp"
#include "server/server_counters.hpp"

namespace fanlight {

class StreamSession;

/// A serialised ServerMessage, shared by all sessions that send it. Server thread only.
using SharedMessage = std::shared_ptr<const std::string>;

/// A picture as it goes to sessions.
struct PictureOffer {
  SharedMessage message;
  std::uint64_t picture_id = 0;
  std::uint64_t scene_revision = 0;
  bool key = true;  ///< it can be shown without those before it
};

/// Hands each picture to every session, encoded once for all that want it alike, and not at all for nobody.
/// Server thread only.
class PictureHub {
 public:
  explicit PictureHub(ServerCounters& counters) : counters_(counters) {}

  /// Offers the picture, which must stay as it is until the next call, to all sessions that one is due to. A
  /// session whose picture cannot be encoded is closed.
  void show(const Picture& picture);

  /// From now on the session is offered each picture, beginning with the one on show. Error: its picture
  /// cannot be encoded.
  Result<void> add(StreamSession& session);

  /// Whether pictures can be had in this way too: only so many ways at a time. Error, kUnavailable: no more.
  Result<void> has_room(const StreamSettings& settings);

  void remove(StreamSession& session) { sessions_.erase(&session); }

  /// The session wants its pictures otherwise now, or has missed one without which the next cannot be shown:
  /// offers it the one on show, or, of a film that others watch as well, sees to it that the next is a key
  /// picture.
  Result<void> begin_anew(StreamSession& session);

  const std::unordered_set<StreamSession*>& sessions() const { return sessions_; }

  /// The newest picture; null before the first.
  const Picture* on_show() const { return on_show_; }

  /// The same as a file, encoded once.
  Result<SharedMessage> png();

 private:
  struct Coding {
    std::unique_ptr<PictureCoder> coder;
    PictureScaler scaler;
    PictureOffer offer;       // of the picture on show, where somebody asked for it
    bool key_wanted = false;  // of the next
    std::int64_t key_ns = 0;  // when the last one was made
  };
  Result<PictureOffer> coded(const StreamSettings& settings, bool key);
  void forget_unused();

  ServerCounters& counters_;
  std::unordered_set<StreamSession*> sessions_;
  std::map<StreamSettings, Coding> codings_;  // by what the code depends on
  const Picture* on_show_ = nullptr;
  std::int64_t last_shown_ns_ = 0;
  std::unique_ptr<PictureCoder> png_coder_;
  SharedMessage png_;  // of the picture on show, once somebody asked for it
};

}  // namespace fanlight
