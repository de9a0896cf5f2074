#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "proto/fanlight.pb.h"
#include "server/connection.hpp"
#include "server/stall_watch.hpp"
#include "server/stream_context.hpp"
#include "server/stream_settings.hpp"

namespace fanlight {

/// One display on its WebSocket: what it sends and is sent. At most one write is under way; besides the few
/// answers that are due, at most one picture waits, and a newer one takes its place and is counted as a skip.
/// A display that does not read costs itself pictures and nobody else anything; one that takes nothing for
/// five seconds, or answers no ping for ten, is dropped. What it asks for is judged in stream_requests.cpp.
///
/// Life: made -> start() -> (a stranger until its token is known ->) open (in the hub) -> closing -> gone;
/// kept alive by its own pending operations. Server thread only.
class StreamSession : public std::enable_shared_from_this<StreamSession> {
 public:
  StreamSession(Connection connection, ConnectionPlace place, const StreamContext& context,
                std::string address);
  ~StreamSession();

  /// Answers the upgrade request and goes on from there. `protocol`: what was agreed on, or empty. Without a
  /// visitor it must show a token first.
  void start(const boost::beast::http::request<boost::beast::http::string_body>& request,
             std::string_view protocol, std::optional<Visitor> visitor);

  std::uint64_t id() const { return id_; }
  const StreamSettings& settings() const { return settings_; }

  /// The view that it sees: 0 for the main one, its own number for its private one.
  std::uint64_t view_id() const { return view_id_; }
  void see(std::uint64_t view_id);

  /// Its private view is another one, or, with a reason, has ended.
  void view_changed(const std::string& ended = "");

  /// The newest picture; replaces one that still waits.
  void offer(const PictureOffer& picture);

  /// Someone changed the scene: tell this display as soon as its socket is free.
  void scene_changed();

  /// Someone else is in control, or nobody.
  void control_changed();

  /// The probe's state is another one: tell this display, and answer what it asked of the probe.
  void probe_changed();

  /// A second has passed: sends the statistics, and looks after what has taken too long.
  void second_passed();

  /// Its picture could not be encoded.
  void unserved();

  /// The server ends.
  void abandon() { leave(); }

  /// Sends a close frame with this reason, at most 123 bytes, after the write under way.
  void close(boost::beast::websocket::close_code code, const std::string& reason);

 private:
  void accepted();
  void enter(Visitor visitor, const std::string& name);
  void read();
  void received(boost::beast::error_code failure, std::size_t bytes);
  void handle(const v1::ClientMessage& message);
  void log_in(const v1::Login& login);
  void change_scene(const v1::SceneChange& change);
  void change_probe(const v1::ProbeChange& change);
  void answer_probe_changes();
  void change_control(const v1::ControlRequest& request);
  Result<bool> wish(const v1::ControlRequest& request);
  void change_view(const v1::ViewChange& change);
  void change_stream(const v1::StreamRequest& request);
  void tell_depth(const v1::DepthRequest& request);
  void refuse(const std::string& sentence);
  void answer(const v1::ServerMessage& message);
  /// Of what anybody can cause at will the log takes some lines a second, and then counts.
  void audit_at_will(const char* what, const std::string& result);
  void audit(const char* what, const std::string& result);
  void audit_changes();
  ControlDesk::Party party() const { return {.session = id_, .name = name_}; }
  void pump();
  void send_picture();
  void write(const SharedMessage& message);
  void written(boost::beast::error_code failure);
  void skip_waiting();
  void cut(const char* why);
  void leave();
  SharedMessage hello() const;
  SharedMessage statistics() const;
  v1::ControlState control_state() const;

  std::shared_ptr<StreamSession> self_;  // while connected: it may have nothing pending, and still be there
  std::uint64_t id_;
  ConnectionPlace place_;
  boost::beast::websocket::stream<Connection> socket_;
  StreamContext context_;
  std::string address_;
  std::optional<Visitor> visitor_;  // none: a stranger
  std::string name_;                // as others see it
  int seconds_ = 0;                 // since the upgrade
  StallWatch stall_;
  boost::beast::flat_buffer incoming_;
  std::deque<SharedMessage> answers_;  // bounded: nothing more is read while it is full
  int readings_left_;                  // of this second, as are the next two
  std::size_t bytes_left_;
  int stream_changes_left_;
  StreamSettings settings_;
  PictureOffer waiting_;
  SharedMessage under_way_;
  bool picture_under_way_ = false;
  bool needs_key_ = false;  // it missed a picture that the next ones build upon
  bool scene_due_ = false;
  bool control_due_ = false;
  bool view_due_ = false;
  std::string view_ended_;  // why, where it was not asked to
  std::uint64_t view_id_ = 0;
  bool probe_due_ = false;
  struct SceneQuestion {
    std::uint64_t view_id;
    std::uint64_t revision;
    std::uint64_t request_id;
  };
  void ask_when_shown(const SceneQuestion& question);
  std::deque<SceneQuestion> changes_unseen_;  // bounded: the oldest go unanswered
  v1::Scene changes_unaudited_;               // of this second
  std::uint64_t changes_unaudited_count_ = 0;
  struct ProbeQuestion {
    std::uint64_t order;       // its number at the desk
    std::uint64_t request_id;  // its client's
  };
  std::deque<ProbeQuestion> probe_questions_;  // bounded: more are refused
  bool statistics_due_ = false;
  bool reading_ = false;
  bool connected_ = false;  // the WebSocket is open
  bool open_ = false;       // and in the hub
  std::optional<boost::beast::websocket::close_reason> closing_;
  bool close_sent_ = false;
  int seconds_closing_ = 0;
  std::uint64_t pictures_offered_ = 0;
  std::uint64_t pictures_sent_ = 0;
  std::uint64_t pictures_skipped_ = 0;
};

}  // namespace fanlight
