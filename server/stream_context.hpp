#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <unordered_set>

#include "server/access_desk.hpp"
#include "server/connection_places.hpp"
#include "server/control_desk.hpp"
#include "server/picture_hub.hpp"
#include "server/probe_desk.hpp"
#include "server/scene_desk.hpp"
#include "server/server_counters.hpp"
#include "server/view_desk.hpp"

namespace fanlight {

/// What a display is told about the house when it connects.
struct HouseFacts {
  std::string source;
  std::string device;
  std::uint32_t picture_width = 0;
  std::uint32_t picture_height = 0;
  int jpeg_quality = 85;  ///< where a session asks for none
};

/// What every session works with; outlives them all. Server thread only.
struct StreamContext {
  const HouseFacts& facts;
  const HouseCounters& house;
  const std::function<std::string()>& source_state;  ///< "running", "ended", or why it failed
  ServerCounters& counters;
  bool loopback_only;  ///< the listener's address: then requests must name it too
  SceneDesk& desk;
  ProbeDesk& probe;
  ViewDesk& views;
  PictureHub& hub;
  AccessDesk& access;
  ControlDesk& control;
  AuditLog& audit;
  std::unordered_set<StreamSession*>& strangers;  ///< connected, and not yet known
  std::uint64_t& sessions_so_far;                 ///< each takes the next number
};

/// Tells every session but one of what it should know, and private views of what is the main one's.
/// `but_session`: 0 for none.
void tell_of_scene(const StreamContext& context, std::uint64_t but_session);
void tell_of_control(const StreamContext& context);

}  // namespace fanlight
