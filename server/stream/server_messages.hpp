// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "proto/fanlight.pb.h"
#include "server/access/control_lease.hpp"
#include "server/access/role.hpp"
#include "server/metrics/server_counters.hpp"
#include "server/state/cine_proxy.hpp"
#include "server/state/picture_liveness.hpp"
#include "server/state/preset_store.hpp"
#include "server/state/probe_proxy.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/state/scene_store.hpp"
#include "server/state/view_admission.hpp"
#include "server/stream/outgoing_queue.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// Description of the server that a client receives when its session opens.
struct ServerDescription {
  std::string source;  ///< as on the command line; may be the path of a file, which only an admin is told
  std::string title;   ///< for everyone
  std::string path;    ///< of the recording that is played; told to nobody
  std::string device;
  std::uint32_t picture_width = 0;
  std::uint32_t picture_height = 0;
  int jpeg_quality = 85;           ///< if a session asks for none
  std::vector<std::string> notes;  ///< see SourceDescription::notes, and DefaultView::note()
};

/// The client of a session.
struct SessionIdentity {
  std::uint64_t id = 0;
  std::string address;
  std::optional<Principal> principal;  ///< empty until the client is authenticated
  std::string name;                    ///< as the other sessions see it

  ControlLease::Party party() const { return {.session = id, .name = name}; }
};

/// Writes the messages that tell clients the state of the server. Server thread only.
class ServerMessages {
 public:
  /// All must outlive this object.
  struct Dependencies {
    const ServerDescription& description;
    const PipelineCounters& pipeline;
    const std::function<std::string()>& source_state;  ///< "running", "ended", or why it failed
    const SceneStore& scene_store;
    const ProbeProxy& probe;
    const PictureLiveness& liveness;
    const RecordingProxy& recording;
    const ReplayProxy& replay;
    const CineProxy& cine;
    const PresetStore& presets;
    const bool& relayed;  ///< the pictures are sent beyond the room
    const ViewAdmission& views;
    const ControlLease& control;
    const PictureHub& hub;
  };
  explicit ServerMessages(const Dependencies& dependencies) : dependencies_(dependencies) {}

  /// Precondition: the client is authenticated.
  v1::ServerMessage hello(const SessionIdentity& session) const;
  /// `reason`: why what the client has shown does not suffice; empty: it has shown nothing.
  static v1::ServerMessage login_needed(const std::string& reason);
  static v1::ServerMessage error(const std::string& sentence);
  v1::ServerMessage control(std::uint64_t session) const;
  v1::ServerMessage scene() const;
  /// `ended`: why the server has ended the private view of the session; else empty.
  v1::ServerMessage view(std::uint64_t session, const std::string& ended) const;
  v1::ServerMessage probe_status() const;
  v1::ServerMessage liveness() const;
  v1::ServerMessage recording() const;
  v1::ServerMessage replay() const;
  v1::ServerMessage cine() const;
  v1::ServerMessage presets() const;
  v1::ServerMessage relay() const;
  bool is_relayed() const { return dependencies_.relayed; }
  v1::ServerMessage statistics(const OutgoingQueue::PictureCounts& pictures) const;
  static v1::ServerMessage scene_shown(const OutgoingQueue::ShownRequest& request, std::uint64_t picture_id);

  /// Who holds control, as this session sees it.
  v1::ControlState control_state(std::uint64_t session) const;

 private:
  Dependencies dependencies_;
};

SharedMessage serialised(const v1::ServerMessage& message);

}  // namespace fanlight
