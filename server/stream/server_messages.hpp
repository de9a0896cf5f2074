// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/fanlight.pb.h"
#include "server/access/control_lease.hpp"
#include "server/access/session_identity.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/outgoing_queue.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// Writes the messages with the state of the server for clients. Server thread only.
class ServerMessages {
 public:
  /// All must outlive this object.
  ServerMessages(const ServerState& state, const ControlLease& control, const PictureHub& hub)
      : state_(state), control_(control), hub_(hub) {}

  /// Precondition: the client is authenticated.
  v1::ServerMessage hello(const SessionIdentity& session) const;
  /// `reason`: why what the client has shown does not suffice; empty: it has shown nothing.
  static v1::ServerMessage login_needed(const std::string& reason);
  static v1::ServerMessage error(const std::string& sentence);
  v1::ServerMessage control(std::uint64_t session) const;
  /// `withdrawn`: why the last change was withdrawn; empty: it was not, or the client knows.
  v1::ServerMessage scene(const std::string& withdrawn) const;
  /// `ended`: why the server has ended the private view of the session; else empty.
  v1::ServerMessage view(std::uint64_t session, const std::string& ended) const;
  v1::ServerMessage probe_status() const;
  v1::ServerMessage liveness() const;
  v1::ServerMessage recording() const;
  v1::ServerMessage replay() const;
  v1::ServerMessage cine() const;
  v1::ServerMessage presets() const;
  /// What a session has not got that knows all measurements up to `known_revision`, which it then raises.
  /// True: others follow.
  bool add_measurements(v1::ServerMessage& message, std::uint64_t& known_revision) const;
  v1::ServerMessage relay() const;
  v1::ServerMessage statistics(const OutgoingQueue::PictureCounts& pictures) const;
  static v1::ServerMessage scene_shown(const OutgoingQueue::ShownRequest& request, std::uint64_t picture_id);

  /// Who holds control, as this session sees it.
  v1::ControlState control_state(std::uint64_t session) const;

 private:
  static std::uint64_t random_id();

  const ServerState& state_;
  const ControlLease& control_;
  const PictureHub& hub_;
  const std::uint64_t run_id_ = random_id();  ///< Hello.run_id
};

SharedMessage serialised(const v1::ServerMessage& message);

}  // namespace fanlight
