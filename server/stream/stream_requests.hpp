// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/websocket/rfc6455.hpp>
#include <cstdint>
#include <deque>
#include <string>

#include "proto/fanlight.pb.h"
#include "server/access/authenticator.hpp"
#include "server/access/control_lease.hpp"
#include "server/metrics/server_counters.hpp"
#include "server/state/cine_proxy.hpp"
#include "server/state/preset_store.hpp"
#include "server/state/probe_proxy.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/state/scene_store.hpp"
#include "server/state/survey_desk.hpp"
#include "server/state/view_admission.hpp"
#include "server/stream/input_budget.hpp"
#include "server/stream/outgoing_queue.hpp"
#include "server/stream/picture_hub.hpp"
#include "server/stream/server_messages.hpp"
#include "server/stream/session_audit.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Carries out what one client asks for: login, changes of the scene, of its private view, of the probe, of
/// the control and of its stream. Every request is answered through the outgoing queue. Server thread only.
class StreamRequests {
 public:
  /// What all sessions share.
  struct Dependencies {
    ServerCounters& counters;
    SceneStore& scene_store;
    ProbeProxy& probe;
    ViewAdmission& views;
    SurveyDesk& surveys;
    RecordingProxy& recording;
    ReplayProxy& replay;
    CineProxy& cine;
    PresetStore& presets;
    PictureHub& hub;
    Authenticator& access;
    ControlLease& control;
    SessionRegistry& sessions;
    const ServerMessages& messages;
    int jpeg_quality;  ///< if a client asks for none
  };

  /// The session, as far as requests change it.
  class Session : public PictureSubscriber {
   public:
    virtual const SessionIdentity& identity() const = 0;

    /// The client is authenticated. `name`: as the other sessions see it; empty: the principal's.
    virtual void open(const Principal& principal, const std::string& name) = 0;
    virtual void set_name(const std::string& name) = 0;
    virtual void set_settings(const StreamSettings& settings) = 0;
    /// The session has a private view again: the end of the one before is no longer reported.
    virtual void forget_view_end() = 0;
    /// Sends a close frame with this reason, at most 123 bytes, after the answers.
    virtual void close(boost::beast::websocket::close_code code, const std::string& reason) = 0;
  };

  /// All must outlive this object.
  StreamRequests(const Dependencies& dependencies, Session& session, SessionAudit& audit,
                 OutgoingQueue& queue, InputBudget& budget)
      : dependencies_(dependencies), session_(session), audit_(audit), queue_(queue), budget_(budget) {}

  void handle(const v1::ClientMessage& message);

  /// Answers a message that is no request with an Error.
  void refuse(const std::string& sentence);

  /// The state of the probe has changed: answers the requests that the probe has answered.
  void answer_probe_changes();

 private:
  const SessionIdentity& identity() const { return session_.identity(); }
  ControlLease::Party party() const { return identity().party(); }
  Role role() const { return identity().principal->role; }

  void log_in(const v1::Login& login);
  void change_scene(const v1::SceneChange& change);
  void change_view(const v1::ViewChange& change);
  void leave_view(v1::ServerMessage& message);
  void change_probe(const v1::ProbeChange& change);
  Result<std::uint64_t> order_of_probe(const v1::ProbeSettings& settings);
  void change_control(const v1::ControlRequest& request);
  Result<bool> apply_wish(const v1::ControlRequest& request);
  void change_stream(const v1::StreamRequest& request);
  Result<void> may_change_stream(const StreamSettings& settings);
  void answer_clock(const v1::ClockRequest& request);
  void answer_depth(const v1::DepthRequest& request);
  void find_surface(const v1::SurveyRequest& request);
  void record(const v1::RecordingRequest& request);
  void control_replay(const v1::ReplayRequest& request);
  void control_cine(const v1::CineRequest& request);
  void change_presets(const v1::PresetRequest& request);
  template <typename Proxy, typename Request, typename Reply>
  void carry_out(Proxy& proxy, const Request& request, Reply& reply, Counter& refusals);
  void answer(const v1::ServerMessage& message) { queue_.add_answer(serialised(message)); }

  const Dependencies& dependencies_;
  Session& session_;
  SessionAudit& audit_;
  OutgoingQueue& queue_;
  InputBudget& budget_;
  /// A change of the probe that the probe has not answered.
  struct PendingProbeChange {
    std::uint64_t order;       // number that ProbeProxy gave it
    std::uint64_t request_id;  // number that the client gave it
    bool acquired_control;     // the session did not hold it before
  };
  std::deque<PendingProbeChange> pending_probe_changes_;  // at most kMostPendingProbeChanges
};

}  // namespace fanlight
