#pragma once

#include <map>
#include <memory>
#include <string>
#include <unordered_set>
#include <utility>

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
  std::uint64_t view_id = 0;
  bool key = true;  ///< it can be shown without those before it
};

/// Hands each picture to every session that sees its view, encoded once for all that want it alike, and not
/// at all for nobody. Server thread only.
class PictureHub {
 public:
  explicit PictureHub(ServerCounters& counters) : counters_(counters) {}

  /// Offers the picture, which must stay as it is until the next call for its view, to all sessions that see
  /// the view and that one is due to. A session sees its private view from that one's first picture on. A
  /// session whose picture cannot be encoded is closed.
  void show(const Picture& picture);

  /// The session has no private view any more: it sees the main one.
  void forget_view(StreamSession& session);

  /// From now on the session is offered each picture, beginning with the one on show. Error: its picture
  /// cannot be encoded.
  Result<void> add(StreamSession& session);

  /// Whether pictures can be had in this way too: only so many ways at a time. Error, kUnavailable: no more.
  Result<void> has_room(std::uint64_t view_id, const StreamSettings& settings);

  /// And its private view with it.
  void remove(StreamSession& session);

  /// The session wants its pictures otherwise now, or has missed one without which the next cannot be shown:
  /// offers it the one on show, or, of a film that others watch as well, sees to it that the next is a key
  /// picture.
  Result<void> begin_anew(StreamSession& session);

  const std::unordered_set<StreamSession*>& sessions() const { return sessions_; }

  /// The newest picture of a view; null before the first.
  const Picture* on_show(std::uint64_t view_id = 0) const {
    const auto shown = on_show_.find(view_id);
    return shown == on_show_.end() ? nullptr : shown->second.picture;
  }

  /// That of the main view as a file, encoded once.
  Result<SharedMessage> png();

 private:
  struct Coding {
    std::unique_ptr<PictureCoder> coder;
    PictureScaler scaler;
    PictureOffer offer;       // of the picture on show, where somebody asked for it
    bool key_wanted = false;  // of the next
    std::int64_t key_ns = 0;  // when the last one was made
  };
  /// The view, and of the settings what the code depends on.
  using Way = std::pair<std::uint64_t, StreamSettings>;
  static Way way_of(const StreamSession& session);
  Result<PictureOffer> coded(const Way& way, bool key);
  void forget_unused();

  ServerCounters& counters_;
  std::unordered_set<StreamSession*> sessions_;
  struct OnShow {
    const Picture* picture = nullptr;
    std::int64_t since_ns = 0;
  };
  std::map<Way, Coding> codings_;
  std::map<std::uint64_t, OnShow> on_show_;  // by view
  std::unique_ptr<PictureCoder> png_coder_;
  SharedMessage png_;  // of the picture on show, once somebody asked for it
};

}  // namespace fanlight
