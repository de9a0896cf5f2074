#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "proto/fanlight.pb.h"
#include "server/stream_context.hpp"

namespace fanlight {

/// One display on its WebSocket. At most one write is under way; besides the few answers that are due, at
/// most one picture waits, and a newer one takes its place and is counted as a skip. A display that does not
/// read costs itself pictures and nobody else anything; one that answers no ping for ten seconds is dropped.
///
/// Life: made -> start() -> open (in the hub) -> closing -> gone; kept alive by its own pending operations.
/// Server thread only.
class StreamSession : public std::enable_shared_from_this<StreamSession> {
 public:
  StreamSession(boost::beast::tcp_stream stream, ConnectionPlace place, const StreamContext& context)
      : place_(std::move(place)), socket_(std::move(stream)), context_(context) {}
  ~StreamSession();

  /// Answers the upgrade request and goes on from there.
  void start(const boost::beast::http::request<boost::beast::http::empty_body>& request);

  /// The newest picture; replaces one that still waits.
  void offer(const SharedMessage& picture);

  /// Someone changed the scene: tell this display as soon as its socket is free.
  void scene_changed();

  /// The probe's state is another one: tell this display, and answer what it asked of the probe.
  void probe_changed();

  /// A second has passed: send the statistics.
  void statistics_due();

  /// Sends a close frame with this reason, at most 123 bytes, after the write under way.
  void close(boost::beast::websocket::close_code code, const std::string& reason);

 private:
  void opened();
  void read();
  void received(boost::beast::error_code failure, std::size_t bytes);
  void handle(const v1::ClientMessage& message);
  void change_scene(const v1::SceneChange& change);
  void change_probe(const v1::ProbeChange& change);
  void answer_probe_changes();
  void refuse(const std::string& sentence);
  void answer(const v1::ServerMessage& message);
  void pump();
  void write(const SharedMessage& message);
  void written(boost::beast::error_code failure);
  void leave();
  SharedMessage hello() const;
  SharedMessage statistics() const;

  ConnectionPlace place_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  StreamContext context_;
  boost::beast::flat_buffer incoming_;
  std::deque<SharedMessage> answers_;  // bounded: nothing more is read while it is full
  SharedMessage waiting_picture_;
  SharedMessage under_way_;
  bool picture_under_way_ = false;
  bool scene_due_ = false;
  bool probe_due_ = false;
  struct ProbeQuestion {
    std::uint64_t order;       // its number at the desk
    std::uint64_t request_id;  // its client's
  };
  std::deque<ProbeQuestion> probe_questions_;  // bounded: more are refused
  bool statistics_due_ = false;
  bool reading_ = false;
  bool open_ = false;
  std::optional<boost::beast::websocket::close_reason> closing_;
  bool close_sent_ = false;
  std::uint64_t pictures_offered_ = 0;
  std::uint64_t pictures_sent_ = 0;
  std::uint64_t pictures_skipped_ = 0;
};

}  // namespace fanlight
