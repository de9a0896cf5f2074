#include "server/stream_session.hpp"

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>

#include "proto/clock.hpp"
#include "server/scene_message.hpp"

namespace fanlight {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

namespace {

constexpr std::uint32_t kProtocolVersion = 1;

// A scene change with every field is under 1 KB.
constexpr std::size_t kLargestMessageBytes = 64 << 10;
// Up to here a message is read to its end, so that its sender can be told why it was refused; beyond, the
// connection is cut.
constexpr std::size_t kLargestReadBytes = 1 << 20;
constexpr std::size_t kMostAnswers = 16;

SharedMessage serialised(const v1::ServerMessage& message) {
  return std::make_shared<const std::string>(message.SerializeAsString());
}

}  // namespace

StreamSession::~StreamSession() {
  leave();
}

void StreamSession::start(const beast::http::request<beast::http::empty_body>& request) {
  // The WebSocket keeps its own time from here on.
  beast::get_lowest_layer(socket_).expires_never();
  socket_.set_option(websocket::stream_base::timeout{.handshake_timeout = std::chrono::seconds(10),
                                                     .idle_timeout = std::chrono::seconds(10),
                                                     .keep_alive_pings = true});
  socket_.read_message_max(kLargestReadBytes);
  socket_.binary(true);
  socket_.auto_fragment(false);
  socket_.async_accept(request, [self = shared_from_this()](beast::error_code failure) {
    if (!failure) self->opened();
  });
}

void StreamSession::opened() {
  open_ = true;
  context_.counters.sessions_opened.add();
  answers_.push_back(hello());
  probe_due_ = context_.probe.status().state != ProbeStatus::State::kAbsent;
  if (auto added = context_.hub.add(*this); !added) {
    close(websocket::close_code::internal_error, "the picture could not be encoded");
  }
  read();
  pump();
}

void StreamSession::leave() {
  if (!open_) return;
  open_ = false;
  context_.hub.remove(*this);
  context_.counters.sessions_closed.add();
  for (const bool unsent : {waiting_picture_ != nullptr, picture_under_way_}) {
    if (unsent) context_.counters.pictures_skipped.add();
  }
  waiting_picture_ = nullptr;
  picture_under_way_ = false;
}

void StreamSession::offer(const SharedMessage& picture) {
  ++pictures_offered_;
  context_.counters.pictures_offered.add();
  if (waiting_picture_ != nullptr) {
    ++pictures_skipped_;
    context_.counters.pictures_skipped.add();
  }
  waiting_picture_ = picture;
  pump();
}

void StreamSession::scene_changed() {
  scene_due_ = true;
  pump();
}

void StreamSession::probe_changed() {
  probe_due_ = true;
  answer_probe_changes();
  pump();
}

void StreamSession::statistics_due() {
  statistics_due_ = true;
  pump();
}

void StreamSession::close(websocket::close_code code, const std::string& reason) {
  if (!closing_) closing_.emplace(code, reason);
  pump();
}

void StreamSession::read() {
  if (reading_ || closing_ || answers_.size() >= kMostAnswers) return;
  reading_ = true;
  socket_.async_read(incoming_, [self = shared_from_this()](beast::error_code failure, std::size_t bytes) {
    self->received(failure, bytes);
  });
}

void StreamSession::received(beast::error_code failure, std::size_t bytes) {
  reading_ = false;
  if (failure) {
    if (failure == websocket::error::message_too_big) context_.counters.messages_refused.add();
    leave();
    return;
  }
  v1::ClientMessage message;
  const auto data = incoming_.cdata();
  if (bytes > kLargestMessageBytes) {
    refuse(fmt::format("a message has {} bytes, expected at most {}", bytes, kLargestMessageBytes));
    close(websocket::close_code::too_big, "a message was too long");
  } else if (!socket_.got_binary()) {
    refuse("a message is text, expected a binary fanlight.v1.ClientMessage");
  } else if (!message.ParseFromArray(data.data(), static_cast<int>(data.size()))) {
    refuse(
        fmt::format("a message of {} bytes could not be read, expected a fanlight.v1.ClientMessage", bytes));
  } else {
    handle(message);
  }
  incoming_.consume(incoming_.size());
  read();
  pump();
}

void StreamSession::handle(const v1::ClientMessage& message) {
  switch (message.body_case()) {
    case v1::ClientMessage::kSceneChange:
      change_scene(message.scene_change());
      break;
    case v1::ClientMessage::kClockRequest: {
      v1::ServerMessage reply;
      reply.mutable_clock_reply()->set_client_time_ms(message.clock_request().client_time_ms());
      reply.mutable_clock_reply()->set_server_time_ns(now_ns());
      answer(reply);
      break;
    }
    case v1::ClientMessage::kProbeChange:
      change_probe(message.probe_change());
      break;
    case v1::ClientMessage::BODY_NOT_SET:
      refuse("a message has no body, expected a scene_change, a probe_change or a clock_request");
      break;
  }
}

void StreamSession::change_scene(const v1::SceneChange& change) {
  v1::ServerMessage message;
  v1::SceneReply& reply = *message.mutable_scene_reply();
  reply.set_request_id(change.request_id());
  const auto applied = context_.desk.apply(change.scene());
  if (applied) {
    context_.counters.scene_changes.add();
    *reply.mutable_in_force() = scene_state(context_.desk.in_force());
  } else {
    context_.counters.scene_refusals.add();
    reply.mutable_refused()->set_message(applied.error().message);
  }
  answer(message);
  if (!applied || !*applied) return;
  for (StreamSession* session : context_.hub.sessions()) {
    if (session != this) session->scene_changed();
  }
}

void StreamSession::change_probe(const v1::ProbeChange& change) {
  // They wait for the probe, and the session must go on reading meanwhile.
  const bool room = probe_questions_.size() < kMostAnswers;
  const auto order =
      room ? context_.probe.order(change.settings())
           : Error{
                 ErrorCode::kUnavailable,
                 fmt::format("{} changes of the probe are unanswered, expected some patience", kMostAnswers)};
  if (order) {
    probe_questions_.push_back({.order = *order, .request_id = change.request_id()});
    return;
  }
  context_.counters.probe_refusals.add();
  v1::ServerMessage message;
  message.mutable_probe_reply()->set_request_id(change.request_id());
  message.mutable_probe_reply()->mutable_refused()->set_message(order.error().message);
  answer(message);
}

void StreamSession::answer_probe_changes() {
  const ProbeStatus& status = context_.probe.status();
  while (!probe_questions_.empty() && probe_questions_.front().order <= status.order_answered) {
    v1::ServerMessage message;
    v1::ProbeReply& reply = *message.mutable_probe_reply();
    reply.set_request_id(probe_questions_.front().request_id);
    probe_questions_.pop_front();
    if (status.refusal.empty()) {
      context_.counters.probe_changes.add();
      *reply.mutable_in_force() = settings_message(status.settings);
    } else {
      context_.counters.probe_refusals.add();
      reply.mutable_refused()->set_message(status.refusal);
    }
    answer(message);
  }
}

void StreamSession::refuse(const std::string& sentence) {
  context_.counters.messages_refused.add();
  v1::ServerMessage message;
  message.mutable_error()->set_message(sentence);
  answer(message);
}

void StreamSession::answer(const v1::ServerMessage& message) {
  answers_.push_back(serialised(message));
}

void StreamSession::pump() {
  if (!open_ || under_way_ != nullptr || close_sent_) return;
  if (!answers_.empty()) {
    const SharedMessage next = answers_.front();
    answers_.pop_front();
    write(next);
  } else if (closing_) {
    close_sent_ = true;
    socket_.async_close(
        *closing_, [self = shared_from_this()](beast::error_code /*gone either way*/) { self->leave(); });
  } else if (std::exchange(scene_due_, false)) {
    v1::ServerMessage message;
    *message.mutable_scene() = scene_state(context_.desk.in_force());
    *message.mutable_scene()->mutable_default_scene() = scene_message(context_.desk.default_scene());
    write(serialised(message));
  } else if (std::exchange(probe_due_, false)) {
    v1::ServerMessage message;
    *message.mutable_probe_status() = context_.probe.message();
    write(serialised(message));
  } else if (std::exchange(statistics_due_, false)) {
    write(statistics());
  } else if (waiting_picture_ != nullptr) {
    picture_under_way_ = true;
    write(std::exchange(waiting_picture_, nullptr));
  }
}

void StreamSession::write(const SharedMessage& message) {
  under_way_ = message;
  socket_.async_write(boost::asio::buffer(*under_way_),
                      [self = shared_from_this()](beast::error_code failure, std::size_t /*bytes*/) {
                        self->written(failure);
                      });
}

void StreamSession::written(beast::error_code failure) {
  under_way_ = nullptr;
  if (failure) {
    leave();
    return;
  }
  if (std::exchange(picture_under_way_, false)) {
    ++pictures_sent_;
    context_.counters.pictures_sent.add();
  }
  read();  // the answers may have left room for another question
  pump();
}

SharedMessage StreamSession::hello() const {
  v1::ServerMessage message;
  v1::Hello& hello = *message.mutable_hello();
  hello.set_protocol_version(kProtocolVersion);
  hello.set_server_version(FANLIGHT_VERSION);
  hello.set_source(context_.facts.source);
  hello.set_device(context_.facts.device);
  hello.set_picture_width(context_.facts.picture_width);
  hello.set_picture_height(context_.facts.picture_height);
  add_scene_fields(hello);
  *hello.mutable_scene() = scene_state(context_.desk.in_force());
  *hello.mutable_default_scene() = scene_message(context_.desk.default_scene());
  return serialised(message);
}

SharedMessage StreamSession::statistics() const {
  const HouseCounters& house = context_.house;
  v1::ServerMessage message;
  v1::Statistics& to = *message.mutable_statistics();
  to.set_server_time_ns(now_ns());
  const AcquisitionCounters& frames = house.acquisition;
  frames.ledger.read([&] {
    to.set_frames_received(frames.frames_received.value());
    to.set_frames_lost(frames.frames_lost());
  });
  to.set_volumes_interpolated(frames.volumes_interpolated.value());
  to.set_mismatch_deg(frames.mismatch_deg.value());
  to.set_mismatch_left_deg(frames.mismatch_left_deg.value());
  to.set_mismatch_left_mm(frames.mismatch_left_mm.value());
  to.set_volumes_assembled(house.ring.volumes_published.value());
  to.set_volumes_dropped(house.ring.volumes_dropped.value());
  to.set_pass1_runs(house.render.pass1_runs.value());
  to.set_pass2_runs(house.render.pass2_runs.value());
  to.set_pictures_rendered(house.render.pictures_finished.value());
  to.set_pictures_offered(pictures_offered_);
  to.set_pictures_sent(pictures_sent_);
  to.set_pictures_skipped(pictures_skipped_);
  to.set_sessions(static_cast<std::uint32_t>(context_.hub.sessions().size()));
  to.set_source_state(context_.probe.lost() ? "probe lost" : context_.source_state());
  return serialised(message);
}

}  // namespace fanlight
