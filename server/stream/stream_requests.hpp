// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/websocket/rfc6455.hpp>
#include <cstdint>
#include <functional>
#include <string>

#include "proto/fanlight.pb.h"
#include "server/access/authenticator.hpp"
#include "server/access/control_lease.hpp"
#include "server/command/command_executor.hpp"
#include "server/command/session_audit.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/input_budget.hpp"
#include "server/stream/outgoing_queue.hpp"
#include "server/stream/picture_hub.hpp"
#include "server/stream/server_messages.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Translates the messages of one client into commands, and the answers back. Login, the clock, depths and
/// the settings of its stream concern this client alone and are handled here. Every request is answered
/// through the outgoing queue. Server thread only.
class StreamRequests {
 public:
  /// What all sessions share.
  struct Dependencies {
    ServerState& state;
    CommandExecutor& commands;
    PictureHub& hub;
    Authenticator& access;
    ControlLease& control;
    SessionRegistry& sessions;
    const ServerMessages& messages;
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
    /// Makes and sends an answer. Where memory runs out, this session ends and the caller continues.
    virtual void send(const std::function<v1::ServerMessage()>& make) = 0;
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

 private:
  const SessionIdentity& identity() const { return session_.identity(); }
  /// Executes a command. The answer is a Reply with the request id, and with the refusal or what `done`
  /// writes. It may come after this returns: see CommandExecutor::execute().
  template <typename Reply, typename Done>
  void execute(const ClientCommand& command, std::uint64_t request_id,
               Reply* (v1::ServerMessage::*reply_of)(), Done done);

  void log_in(const v1::Login& login);
  void change_scene(const v1::SceneChange& change);
  void change_view(const v1::ViewChange& change);
  void leave_view(std::uint64_t request_id);
  void change_probe(const v1::ProbeChange& change);
  void change_control(const v1::ControlRequest& request);
  void change_stream(const v1::StreamRequest& request);
  Result<void> may_change_stream(const StreamSettings& settings);
  void answer_clock(const v1::ClockRequest& request);
  void answer_depth(const v1::DepthRequest& request);
  void find_surface(const v1::SurveyRequest& request);
  void measure_fluid(const v1::FluidRequest& request);
  void record(const v1::RecordingRequest& request);
  void control_replay(const v1::ReplayRequest& request);
  void control_cine(const v1::CineRequest& request);
  void change_presets(const v1::PresetRequest& request);
  void change_measurements(const v1::MeasurementRequest& request);
  void answer(const v1::ServerMessage& message) { queue_.add_answer(serialised(message)); }

  const Dependencies& dependencies_;
  Session& session_;
  SessionAudit& audit_;
  OutgoingQueue& queue_;
  InputBudget& budget_;
  v1::FluidRegion found_region_;  // by the last FluidRequest that found one
};

}  // namespace fanlight
