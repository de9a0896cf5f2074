#pragma once

#include <memory>
#include <string>
#include <unordered_set>

#include "proto/picture.hpp"
#include "server/picture_encoder.hpp"
#include "server/server_counters.hpp"

namespace fanlight {

class StreamSession;

/// A serialised ServerMessage, shared by all sessions that send it. Server thread only.
using SharedMessage = std::shared_ptr<const std::string>;

/// Hands each picture to every session, encoded once however many there are, and not at all while there is
/// none. Server thread only.
class PictureHub {
 public:
  struct Config {
    int jpeg_quality = 85;
  };

  PictureHub(const Config& config, ServerCounters& counters)
      : encoder_(config.jpeg_quality), counters_(counters) {}

  /// Offers the picture, which must stay as it is until the next call, to all sessions.
  Result<void> show(const Picture& picture);

  /// From now on the session is offered each picture, beginning with the one on show.
  Result<void> add(StreamSession& session);
  void remove(StreamSession& session) { sessions_.erase(&session); }

  const std::unordered_set<StreamSession*>& sessions() const { return sessions_; }

 private:
  Result<void> encode();

  PictureEncoder encoder_;
  ServerCounters& counters_;
  std::unordered_set<StreamSession*> sessions_;
  const Picture* on_show_ = nullptr;
  SharedMessage message_;  // of the picture on show, once somebody asked for it
};

}  // namespace fanlight
