// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "server/command/session_audit.hpp"
#include "server/net/connection.hpp"
#include "server/net/connection_limit.hpp"
#include "server/net/send_progress.hpp"
#include "server/stream/session_registry.hpp"
#include "server/stream/stream_session.hpp"

namespace fanlight {

/// A client that watches the main view as Motion JPEG over HTTP: multipart/x-mixed-replace, as browsers show
/// it in an <img>. Nothing beside the pictures is shown there, so words in them say where they are not live.
/// One write is under way, and one picture waits; a newer one replaces it. A client that acknowledges no byte
/// for five seconds is disconnected.
///
/// SessionRegistry and the pending operations keep it alive. Server thread only.
class MjpegSession : public PictureSubscriber,
                     public RegisteredSession,
                     public std::enable_shared_from_this<MjpegSession> {
 public:
  using Response = boost::beast::http::response<boost::beast::http::string_body>;
  static constexpr const char* kMediaType = "multipart/x-mixed-replace; boundary=fanlight-picture";

  /// `dependencies` and all that it refers to must outlive the session. `address`: of the client, with port.
  MjpegSession(Connection connection, ConnectionPermit permit,
               const StreamSession::Dependencies& dependencies, std::string address);

  /// Sends `head`, and pictures until the client leaves; without pictures if it asked for the head alone.
  void start(Response head, const Principal& principal, const StreamSettings& settings, bool head_only);

  // PictureSubscriber.
  std::uint64_t id() const override { return identity_.id; }
  std::uint64_t view_id() const override { return 0; }
  void set_view(std::uint64_t /*view_id*/) override {}
  const StreamSettings& settings() const override { return settings_; }
  bool privileged() const override { return has_role(identity_.principal->role, kEncodesUnlimited); }
  void offer(const PictureOffer& picture) override;
  void encoding_failed() override { must_leave_ = true; }

  // RegisteredSession.
  bool is_open() const override { return is_open_; }
  void notify(Notice notice) override;
  void view_ended(const std::string& /*reason*/) override {}
  void scene_withdrawn(const std::string& /*reason*/) override {}
  void second_passed() override;
  void end(const std::string& reason) override;
  void abandon() override { leave("the server has ended"); }

 private:
  void pump();
  /// Writes a text, and a picture with what follows it unless it is empty.
  void write(std::string text, std::string picture);
  void written(boost::beast::error_code failure);
  void watch_for_end();
  void leave(const std::string& why);

  const StreamSession::Dependencies& dependencies_;
  const StreamRequests::Dependencies& shared_;
  ConnectionPermit permit_;
  Connection connection_;
  SessionIdentity identity_;
  StreamSettings settings_;
  SessionAudit audit_;
  OutgoingQueue queue_;  // counts what is offered, sent and skipped
  SendProgress progress_;
  std::string text_;  // being written, with picture_ behind it
  std::string picture_;
  std::array<char, 64> ignored_{};  // what the client sends
  bool writing_ = false;
  bool is_open_ = false;
  bool must_leave_ = false;
};

}  // namespace fanlight
