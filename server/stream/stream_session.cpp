// SPDX-License-Identifier: Apache-2.0
#include "server/stream/stream_session.hpp"

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

namespace {

// All that arrives, also control frames and fragments: twice what messages may take.
constexpr std::size_t kReadBytesPerSecond = 2 * InputBudget::kBytesPerSecond;

}  // namespace

/// Handler of an operation on the socket; keeps the session alive. Where it is destroyed without a call,
/// since the library found no memory in the midst of the operation, the session leaves with the next second.
class StreamSession::Operation {
 public:
  using Done = void (StreamSession::*)(beast::error_code failure, std::size_t bytes);

  Operation(std::shared_ptr<StreamSession> session, Done done) : session_(std::move(session)), done_(done) {}
  Operation(Operation&&) = default;
  Operation& operator=(Operation&&) = default;
  ~Operation() {
    if (session_ != nullptr) session_->out_of_memory_ = true;
  }

  void operator()(beast::error_code failure, std::size_t bytes = 0) {
    const auto session = std::exchange(session_, nullptr);
    session->guarded([&] { ((*session).*done_)(failure, bytes); });
  }

 private:
  std::shared_ptr<StreamSession> session_;  // null after a move or a call
  Done done_;
};

StreamSession::StreamSession(Connection connection, ConnectionPermit permit, const Dependencies& dependencies,
                             std::string address)
    : dependencies_(dependencies),
      shared_(dependencies.shared),
      permit_(std::move(permit)),
      socket_(std::move(connection)),
      identity_{.id = shared_.sessions.next_id(),
                .address = std::move(address),
                .principal = std::nullopt,
                .name = ""},
      settings_{.quality = shared_.state.description.jpeg_quality},
      queue_(shared_.state.counters),
      audit_(dependencies.audit, identity_),
      requests_(shared_, *this, audit_, queue_, budget_) {}

void StreamSession::enter(State state) {
  state_ = state;
  seconds_in_state_ = 0;
}

void StreamSession::start(const beast::http::request<beast::http::string_body>& request,
                          std::string_view protocol, std::optional<Principal> principal,
                          const std::string& login_reason) {
  // The WebSocket has time-outs of its own.
  beast::get_lowest_layer(socket_).expires_never();
  socket_.set_option(websocket::stream_base::timeout{.handshake_timeout = std::chrono::seconds(10),
                                                     .idle_timeout = dependencies_.limits.unanswered,
                                                     .keep_alive_pings = true});
  if (!protocol.empty()) {
    socket_.set_option(websocket::stream_base::decorator(
        [protocol = std::string(protocol)](websocket::response_type& response) {
          response.set(beast::http::field::sec_websocket_protocol, protocol);
        }));
  }
  socket_.next_layer().limit_reads(kReadBytesPerSecond);
  socket_.control_callback(
      [this](websocket::frame_type kind, beast::string_view) { count_control_frame(kind); });
  permit_.on_eviction([this] {
    close_reason_.emplace(websocket::close_code::try_again_later, "its place was needed for others");
    beast::get_lowest_layer(socket_).close();  // the pending operations fail, and the session leaves
  });
  socket_.read_message_max(SessionLimits::kLoginBytes);
  socket_.binary(true);
  socket_.auto_fragment(false);
  shown_principal_ = std::move(principal);
  login_reason_ = login_reason;
  socket_.async_accept(request, Operation(shared_from_this(), &StreamSession::accepted));
}

void StreamSession::accepted(beast::error_code failure, std::size_t /*none*/) {
  if (failure) return;
  enter(State::kLogin);
  shared_.sessions.add(shared_from_this());
  if (shown_principal_) {
    open(*shown_principal_, "");
  } else {
    queue_.add_answer(serialised(ServerMessages::login_needed(login_reason_)));
  }
  read();
  pump();
}

void StreamSession::open(const Principal& principal, const std::string& name) {
  identity_.principal = principal;
  permit_.authenticated();
  identity_.name = name.empty() ? principal.name : name;
  socket_.read_message_max(SessionLimits::kReadBytes);
  // A session that is being closed stays so.
  if (state_ == State::kLogin) enter(State::kOpen);
  shared_.state.counters.sessions_opened.add();
  audit_.note("session_opened", "done");
  queue_.add_answer(serialised(shared_.messages.hello(identity_)));
  if (shared_.state.probe.status().state != ProbeStatus::State::kAbsent) queue_.add_notice(Notice::kProbe);
  queue_.add_notice(Notice::kLiveness);
  queue_.add_notice(Notice::kRecording);
  queue_.add_notice(Notice::kReplay);
  queue_.add_notice(Notice::kCine);
  queue_.add_notice(Notice::kPresets);
  queue_.add_notice(Notice::kMeasurements);
  if (shared_.state.is_relayed()) queue_.add_notice(Notice::kRelay);
  shared_.hub.add(*this);
  shared_.sessions.opened();
}

void StreamSession::leave() {
  if (!is_connected()) return;
  const auto self = shared_from_this();  // the registry may hold the last reference
  const bool was_open = is_open();
  enter(State::kGone);
  shared_.sessions.remove(id());
  // Before anything that takes memory: the executor refers to this object.
  shared_.commands.forget(id());
  // A pending operation to a peer that disconnected, or that does not read, would keep the connection for
  // ever.
  beast::get_lowest_layer(socket_).close();
  if (!was_open) return;
  shared_.hub.remove(*this);
  shared_.state.views.leave(id());
  shared_.state.counters.sessions_closed.add();
  queue_.end();
  audit_.flush_changes();
  audit_.note("session_closed",
              close_reason_ ? std::string(close_reason_->reason.c_str()) : "the display left");
}

void StreamSession::encoding_failed() {
  shared_.state.counters.encodings_failed.add();
  close(websocket::close_code::internal_error, "the picture could not be encoded");
}

void StreamSession::offer(const PictureOffer& picture) {
  guarded([&] {
    queue_.offer(picture);
    pump();
  });
}

void StreamSession::set_settings(const StreamSettings& settings) {
  settings_ = settings;
  queue_.begin_stream(settings_.codec == StreamSettings::Codec::kH264);
}

void StreamSession::set_view(std::uint64_t view_id) {
  if (std::exchange(view_id_, view_id) == view_id) return;
  // The pictures of the other view belong to another H.264 stream.
  queue_.begin_stream(settings_.codec == StreamSettings::Codec::kH264);
}

void StreamSession::notify(Notice notice) {
  // The session has another view: the end of the earlier one is no longer reported.
  if (notice == Notice::kView) view_end_.clear();
  add_notice(notice);
}

void StreamSession::add_notice(Notice notice) {
  guarded([&] {
    queue_.add_notice(notice);
    pump();
  });
}

void StreamSession::view_ended(const std::string& reason) {
  guarded([&] {
    shared_.hub.forget_view(*this);
    view_end_ = reason;
  });
  add_notice(Notice::kView);
}

void StreamSession::send(const std::function<v1::ServerMessage()>& make) {
  guarded([&] {
    queue_.add_answer(serialised(make()));
    pump();
  });
}

void StreamSession::count_control_frame(websocket::frame_type kind) {
  // Beast is in the midst of a read: the session ends with the next second.
  if (kind == websocket::frame_type::ping && !budget_.take_ping()) too_many_pings_ = true;
}

void StreamSession::second_passed() {
  guarded([&] { check_limits(); });
}

void StreamSession::check_limits() {
  ++seconds_in_state_;
  budget_.refill();
  const SessionLimits& limits = dependencies_.limits;
  if (state_ == State::kClosing && seconds_in_state_ >= limits.stalled_s)
    return cut("it did not close when asked to");
  if (out_of_memory_) {
    shared_.state.counters.sessions_out_of_memory.add();
    return cut("the server had no memory for it");
  }
  audit_.flush_changes();
  const int stalled = progress_.seconds_stalled(beast::get_lowest_layer(socket_).socket().native_handle(),
                                                under_way_ != nullptr);
  if (stalled >= limits.stalled_s) {
    shared_.state.counters.sessions_stalled.add();
    return cut(fmt::format("it took nothing for {} s", limits.stalled_s));
  }
  if (too_many_pings_ && state_ != State::kClosing) {
    shared_.state.counters.messages_refused.add();
    close(websocket::close_code::policy_error,
          fmt::format("over {} pings within a second", InputBudget::kPingsPerSecond));
  }
  if (state_ == State::kLogin && seconds_in_state_ >= limits.login_s)
    close(websocket::close_code::policy_error, "no token was received");
  if (state_ == State::kOpen && !shared_.access.may_stay(*identity_.principal)) {
    close(websocket::close_code::policy_error, "the token or certificate is not valid any more");
  }
  if (is_open()) {
    queue_.add_notice(Notice::kLiveness);
    if (shared_.state.recording.is_active()) queue_.add_notice(Notice::kRecording);
    queue_.add_notice(Notice::kStatistics);
  }
  read();
  pump();
}

void StreamSession::close(websocket::close_code code, const std::string& reason) {
  if (state_ == State::kLogin || state_ == State::kOpen) {
    close_reason_.emplace(code, reason);
    queue_.close();
    enter(State::kClosing);
  }
  pump();
}

void StreamSession::end(const std::string& reason) {
  close(websocket::close_code::going_away, reason);
}

void StreamSession::cut(const std::string& why) {
  // A close frame would wait behind the message that the client does not take.
  if (!close_reason_) close_reason_.emplace(websocket::close_code::going_away, why);
  leave();
}

void StreamSession::fail(beast::error_code failure) {
  // The time-out ends the read and the write under way, in either order.
  if (failure != beast::error::timeout || !is_connected()) return leave();
  shared_.state.counters.sessions_unanswered.add();
  const auto limit = std::chrono::duration_cast<std::chrono::seconds>(dependencies_.limits.unanswered);
  cut(fmt::format("it answered no ping for {} s", limit.count()));
}

void StreamSession::read() {
  if (reading_ || !queue_.has_room() || !budget_.may_read()) return;
  if (state_ != State::kLogin && state_ != State::kOpen) return;
  reading_ = true;
  budget_.begin_read();
  socket_.async_read(incoming_, Operation(shared_from_this(), &StreamSession::received));
}

void StreamSession::received(beast::error_code failure, std::size_t bytes) {
  reading_ = false;
  if (failure) {
    if (failure == websocket::error::message_too_big) shared_.state.counters.messages_refused.add();
    fail(failure);
    return;
  }
  budget_.add_bytes(bytes);
  handle_message(bytes);
  incoming_.consume(incoming_.size());
  read();
  pump();
}

template <typename Handle>
void StreamSession::guarded(Handle handle) {
  try {
    handle();
  } catch (const std::bad_alloc&) {
    // The caller may be in a loop over the sessions: this one leaves with the next second.
    out_of_memory_ = true;
  }
}

void StreamSession::handle_message(std::size_t bytes) {
  v1::ClientMessage message;
  const auto data = incoming_.cdata();
  if (bytes > SessionLimits::kMessageBytes) {
    requests_.refuse(
        fmt::format("a message has {} bytes, expected at most {}", bytes, SessionLimits::kMessageBytes));
    close(websocket::close_code::too_big, "a message was too long");
  } else if (!socket_.got_binary()) {
    requests_.refuse("a message is text, expected a binary fanlight.v1.ClientMessage");
  } else if (!message.ParseFromArray(data.data(), static_cast<int>(data.size()))) {
    requests_.refuse(
        fmt::format("a message of {} bytes could not be read, expected a fanlight.v1.ClientMessage", bytes));
  } else {
    requests_.handle(message);
  }
}

void StreamSession::pump() {
  if (!is_connected() || under_way_ != nullptr) return;
  using Kind = OutgoingQueue::Item::Kind;
  const OutgoingQueue::Item item = queue_.next();
  switch (item.kind) {
    case Kind::kNothing:
      return;
    case Kind::kAnswer:
    case Kind::kPicture:
      return write(item.message);
    case Kind::kClose:
      return send_close();
    case Kind::kNotice:
      return write(serialised(notice_message(item.notice)));
    case Kind::kShown:
      return write(serialised(ServerMessages::scene_shown(item.shown, item.picture_id)));
    case Kind::kNeedsKey:
      return shared_.hub.resync(*this);
  }
}

v1::ServerMessage StreamSession::notice_message(Notice notice) {
  switch (notice) {
    case Notice::kControl:
      return shared_.messages.control(id());
    case Notice::kScene:
      return shared_.messages.scene(std::exchange(withdrawn_, {}));
    case Notice::kView:
      return shared_.messages.view(id(), std::exchange(view_end_, {}));
    case Notice::kProbe:
      return shared_.messages.probe_status();
    case Notice::kLiveness:
      return shared_.messages.liveness();
    case Notice::kRecording:
      return shared_.messages.recording();
    case Notice::kReplay:
      return shared_.messages.replay();
    case Notice::kCine:
      return shared_.messages.cine();
    case Notice::kPresets:
      return shared_.messages.presets();
    case Notice::kMeasurements:
      return measurements();
    case Notice::kRelay:
      return shared_.messages.relay();
    case Notice::kStatistics:
      break;
  }
  return shared_.messages.statistics(queue_.picture_counts());
}

v1::ServerMessage StreamSession::measurements() {
  v1::ServerMessage message;
  if (shared_.messages.add_measurements(message, known_measurements_))
    queue_.add_notice(Notice::kMeasurements);
  return message;
}

void StreamSession::write(const SharedMessage& message) {
  under_way_ = message;
  socket_.async_write(boost::asio::buffer(*under_way_),
                      Operation(shared_from_this(), &StreamSession::written));
}

void StreamSession::written(beast::error_code failure, std::size_t /*bytes*/) {
  under_way_ = nullptr;
  if (failure) {
    fail(failure);
    return;
  }
  queue_.sent();
  read();  // there may be room for another answer
  pump();
}

void StreamSession::closed(beast::error_code /*closed either way*/, std::size_t /*none*/) {
  leave();
}

void StreamSession::send_close() {
  socket_.async_close(*close_reason_, Operation(shared_from_this(), &StreamSession::closed));
}

}  // namespace fanlight
