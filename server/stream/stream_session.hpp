// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "proto/fanlight.pb.h"
#include "server/command/session_audit.hpp"
#include "server/net/connection.hpp"
#include "server/net/connection_limit.hpp"
#include "server/net/send_progress.hpp"
#include "server/stream/input_budget.hpp"
#include "server/stream/outgoing_queue.hpp"
#include "server/stream/server_messages.hpp"
#include "server/stream/session_limits.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_requests.hpp"

namespace fanlight {

/// One display on its WebSocket: owns the socket and the life cycle. At most one read and one write are under
/// way. OutgoingQueue decides what is written, InputBudget how much is read, and StreamRequests carries out
/// the messages. A display that reads slowly loses pictures of its own only. One that acknowledges no byte
/// for five seconds, or answers no ping for ten, is disconnected (SessionLimits).
///
/// SessionRegistry and the pending operations keep it alive. Server thread only.
class StreamSession : public StreamRequests::Session,
                      public RegisteredSession,
                      public std::enable_shared_from_this<StreamSession> {
 public:
  struct Dependencies {
    const StreamRequests::Dependencies& shared;
    AuditLog& audit;
    SessionLimits limits;
  };

  /// `dependencies` and all that it refers to must outlive the session. `address`: of the client, with port.
  StreamSession(Connection connection, ConnectionPermit permit, const Dependencies& dependencies,
                std::string address);

  /// Answers the upgrade request and serves the client. `protocol`: what was agreed on, or empty. Without a
  /// principal the client must log in first, and is sent `login_reason`, or a default one.
  void start(const boost::beast::http::request<boost::beast::http::string_body>& request,
             std::string_view protocol, std::optional<Principal> principal, const std::string& login_reason);

  // PictureSubscriber.
  std::uint64_t id() const override { return identity_.id; }
  std::uint64_t view_id() const override { return view_id_; }
  void set_view(std::uint64_t view_id) override;
  const StreamSettings& settings() const override { return settings_; }
  bool privileged() const override {
    return identity_.principal && has_role(identity_.principal->role, kEncodesUnlimited);
  }
  void offer(const PictureOffer& picture) override;
  void encoding_failed() override;

  // RegisteredSession.
  bool is_open() const override { return identity_.principal.has_value(); }
  void notify(Notice notice) override;
  void view_ended(const std::string& reason) override;
  void scene_withdrawn(const std::string& reason) override { withdrawn_ = reason; }
  void second_passed() override;
  void end(const std::string& reason) override;
  void abandon() override { leave(); }

  // StreamRequests::Session.
  const SessionIdentity& identity() const override { return identity_; }
  void open(const Principal& principal, const std::string& name) override;
  void set_name(const std::string& name) override { identity_.name = name; }
  void set_settings(const StreamSettings& settings) override;
  void forget_view_end() override { view_end_.clear(); }
  void send(const std::function<v1::ServerMessage()>& make) override;
  void close(boost::beast::websocket::close_code code, const std::string& reason) override;

 private:
  enum class State : std::uint8_t {
    kUpgrading,  ///< the WebSocket is not open yet
    kLogin,      ///< waits for a login
    kOpen,       ///< authenticated, and subscribed to the hub
    kClosing,    ///< a close frame is due or was sent; subscribed if it was open
    kGone,       ///< the connection is closed, and nothing refers to the session but pending operations
  };

  bool is_connected() const { return state_ != State::kUpgrading && state_ != State::kGone; }
  void enter(State state);
  void accepted(boost::beast::error_code failure, std::size_t none);
  void read();
  void received(boost::beast::error_code failure, std::size_t bytes);
  void handle_message(std::size_t bytes);
  void count_control_frame(boost::beast::websocket::frame_type kind);
  /// Runs a handler. Where memory runs out, this session ends with the next second, and no other does.
  template <typename Handle>
  void guarded(Handle handle);
  class Operation;
  void add_notice(Notice notice);
  /// Writes what is due next, unless a write is under way.
  void pump();
  v1::ServerMessage notice_message(Notice notice);
  v1::ServerMessage measurements();
  void write(const SharedMessage& message);
  void written(boost::beast::error_code failure, std::size_t bytes);
  void closed(boost::beast::error_code failure, std::size_t bytes);
  void send_close();
  void check_limits();
  /// Leaves after a failed read or write.
  void fail(boost::beast::error_code failure);
  /// Closes the connection without a close frame.
  void cut(const std::string& why);
  void leave();

  const Dependencies& dependencies_;
  const StreamRequests::Dependencies& shared_;
  ConnectionPermit permit_;
  boost::beast::websocket::stream<Connection, false> socket_;  // pictures are compressed already
  State state_ = State::kUpgrading;
  int seconds_in_state_ = 0;
  std::optional<Principal> shown_principal_;  // with the upgrade request
  std::string login_reason_;                  // why that did not suffice; empty: nothing was shown
  std::optional<boost::beast::websocket::close_reason> close_reason_;
  SessionIdentity identity_;
  StreamSettings settings_;
  std::uint64_t view_id_ = 0;
  std::string
      withdrawn_;  // why the server has withdrawn the last change, until the client was told; else empty
  std::string view_end_;  // why the server has ended the private view; else empty
  InputBudget budget_;
  OutgoingQueue queue_;
  SessionAudit audit_;
  StreamRequests requests_;
  SendProgress progress_;
  boost::beast::flat_buffer incoming_;
  bool reading_ = false;
  bool too_many_pings_ = false;
  std::uint64_t known_measurements_ = 0;  // see MeasurementStore::part_after()
  bool out_of_memory_ = false;
  SharedMessage under_way_;  // being written; null: none
};

}  // namespace fanlight
