#include "server/stream_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <nlohmann/json.hpp>

#include "proto/clock.hpp"
#include "server/scene_json.hpp"
#include "server/scene_message.hpp"
#include "server/stream_protocol.hpp"

namespace fanlight {

namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;

namespace {

// A scene change with every field is under 1 KB.
constexpr std::size_t kLargestMessageBytes = 64 << 10;
// Up to here a message is read to its end, so that its sender can be told why it was refused; beyond, the
// connection is cut.
constexpr std::size_t kLargestReadBytes = 1 << 20;
constexpr std::size_t kMostAnswers = 16;
// A dragged light comes with every picture of a fast screen; more is read in the next second.
constexpr int kMostMessagesASecond = 500;
constexpr std::size_t kMostBytesASecond = 256 << 10;
// Each may have a picture encoded anew.
constexpr int kMostStreamChangesASecond = 3;
// Who has shown no token yet has a login to say, and nothing else.
constexpr std::size_t kLargestStrangersMessageBytes = 4 << 10;
constexpr int kSecondsForALogin = 10;
constexpr int kSecondsWithoutProgress = 5;

SharedMessage serialised(const v1::ServerMessage& message) {
  return std::make_shared<const std::string>(message.SerializeAsString());
}

}  // namespace

StreamSession::StreamSession(Connection connection, ConnectionPlace place, const StreamContext& context,
                             std::string address)
    : id_(++context.sessions_so_far),
      place_(std::move(place)),
      socket_(std::move(connection)),
      context_(context),
      address_(std::move(address)),
      readings_left_(kMostMessagesASecond),
      bytes_left_(kMostBytesASecond),
      stream_changes_left_(kMostStreamChangesASecond),
      settings_{.quality = context.facts.jpeg_quality} {}

StreamSession::~StreamSession() {
  leave();
}

void StreamSession::start(const beast::http::request<beast::http::string_body>& request,
                          std::string_view protocol, std::optional<Visitor> visitor) {
  visitor_ = std::move(visitor);
  // The WebSocket keeps its own time from here on.
  beast::get_lowest_layer(socket_).expires_never();
  socket_.set_option(websocket::stream_base::timeout{.handshake_timeout = std::chrono::seconds(10),
                                                     .idle_timeout = std::chrono::seconds(10),
                                                     .keep_alive_pings = true});
  if (!protocol.empty()) {
    socket_.set_option(websocket::stream_base::decorator(
        [protocol = std::string(protocol)](websocket::response_type& response) {
          response.set(beast::http::field::sec_websocket_protocol, protocol);
        }));
  }
  socket_.read_message_max(kLargestStrangersMessageBytes);
  socket_.binary(true);
  socket_.auto_fragment(false);
  socket_.async_accept(request, [self = shared_from_this()](beast::error_code failure) {
    if (!failure) self->accepted();
  });
}

void StreamSession::accepted() {
  connected_ = true;
  self_ = shared_from_this();
  context_.strangers.insert(this);
  if (visitor_) {
    enter(*visitor_, "");
  } else {
    v1::ServerMessage message;
    message.mutable_login_needed()->set_message(
        "this server needs a token, expected a login with one made by `fanlight token add`");
    answer(message);
  }
  read();
  pump();
}

void StreamSession::enter(Visitor visitor, const std::string& name) {
  visitor_ = std::move(visitor);
  name_ = name.empty() ? visitor_->name : name;
  context_.strangers.erase(this);
  socket_.read_message_max(kLargestReadBytes);
  open_ = true;
  context_.counters.sessions_opened.add();
  audit("session_opened", "done");
  answers_.push_back(hello());
  probe_due_ = context_.probe.status().state != ProbeStatus::State::kAbsent;
  if (auto added = context_.hub.add(*this); !added) unserved();
}

void StreamSession::unserved() {
  context_.counters.encodings_failed.add();
  close(websocket::close_code::internal_error, "the picture could not be encoded");
}

void StreamSession::leave() {
  const auto self = std::move(self_);  // may be the last that keeps it
  connected_ = false;
  // What is still under way to a peer that has gone, or that does not read, would keep the connection for
  // ever.
  if (self != nullptr) beast::get_lowest_layer(socket_).close();
  context_.strangers.erase(this);
  if (!open_) return;
  open_ = false;
  context_.hub.remove(*this);
  context_.views.leave(id_);
  context_.counters.sessions_closed.add();
  skip_waiting();
  if (std::exchange(picture_under_way_, false)) {
    ++pictures_skipped_;
    context_.counters.pictures_skipped.add();
  }
  audit_changes();
  audit("session_closed", closing_ ? std::string(closing_->reason.c_str()) : "the display left");
  if (context_.control.left(id_, now_ns() / 1'000'000)) tell_of_control(context_);
}

void StreamSession::skip_waiting() {
  if (waiting_.message == nullptr) return;
  waiting_.message = nullptr;
  ++pictures_skipped_;
  context_.counters.pictures_skipped.add();
}

void StreamSession::offer(const PictureOffer& picture) {
  ++pictures_offered_;
  context_.counters.pictures_offered.add();
  const bool missed = waiting_.message != nullptr;
  skip_waiting();
  needs_key_ |= missed;
  waiting_ = picture;
  if (needs_key_ && !picture.key) {
    skip_waiting();  // the display could make nothing of it
  } else {
    needs_key_ = false;
  }
  pump();
}

void StreamSession::scene_changed() {
  scene_due_ = true;
  pump();
}

void StreamSession::control_changed() {
  control_due_ = true;
  pump();
}

void StreamSession::see(std::uint64_t view_id) {
  if (std::exchange(view_id_, view_id) == view_id) return;
  // Of the other view's pictures none is of use any more, and its film goes on elsewhere.
  skip_waiting();
  needs_key_ = settings_.codec == StreamSettings::Codec::kH264;
}

void StreamSession::view_changed(const std::string& ended) {
  view_due_ = true;
  view_ended_ = ended;
  pump();
}

void StreamSession::probe_changed() {
  probe_due_ = true;
  answer_probe_changes();
  pump();
}

void StreamSession::second_passed() {
  ++seconds_;
  readings_left_ = kMostMessagesASecond;
  bytes_left_ = kMostBytesASecond;
  stream_changes_left_ = kMostStreamChangesASecond;
  if (closing_ && ++seconds_closing_ >= kSecondsWithoutProgress) return cut("it was told to go and did not");
  audit_changes();
  const int stalled = stall_.seconds_stalled(beast::get_lowest_layer(socket_).socket().native_handle(),
                                             under_way_ != nullptr);
  if (stalled >= kSecondsWithoutProgress) {
    context_.counters.sessions_stalled.add();
    return cut("it took nothing for 5 s");
  }
  if (!open_ && seconds_ >= kSecondsForALogin) close(websocket::close_code::policy_error, "no token came");
  if (open_ && !context_.access.may_stay(*visitor_)) {
    close(websocket::close_code::policy_error, "the token or certificate is not valid any more");
  }
  statistics_due_ = open_;
  read();
  pump();
}

void StreamSession::close(websocket::close_code code, const std::string& reason) {
  if (!closing_) closing_.emplace(code, reason);
  pump();
}

void StreamSession::cut(const char* why) {
  // A close frame would wait behind the picture that is not taken.
  if (!closing_) closing_.emplace(websocket::close_code::going_away, why);
  leave();
}

void StreamSession::read() {
  if (!connected_ || reading_ || closing_ || answers_.size() >= kMostAnswers) return;
  if (readings_left_ <= 0 || bytes_left_ == 0) return;  // till the next second
  reading_ = true;
  --readings_left_;
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
  bytes_left_ -= std::min(bytes_left_, bytes);
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

void StreamSession::refuse(const std::string& sentence) {
  context_.counters.messages_refused.add();
  v1::ServerMessage message;
  message.mutable_error()->set_message(sentence);
  answer(message);
}

void StreamSession::answer(const v1::ServerMessage& message) {
  answers_.push_back(serialised(message));
}

void StreamSession::audit(const char* what, const std::string& result) {
  const AuditLog::Event event{.what = what, .session = id_, .result = result};
  if (result.starts_with("refused")) return context_.audit.note_refusal(*visitor_, event);
  context_.audit.note(*visitor_, event);
}

void StreamSession::audit_at_will(const char* what, const std::string& result) {
  context_.audit.note_refusal(*visitor_, {.what = what, .session = id_, .result = result});
}

void StreamSession::audit_changes() {
  const std::uint64_t count = std::exchange(changes_unaudited_count_, 0);
  if (count == 0) return;
  context_.audit.note(*visitor_, {.what = "scene_change", .session = id_, .result = "done"},
                      {{"changes", count}, {"to", change_json(changes_unaudited_)}});
  changes_unaudited_.Clear();
}

void StreamSession::pump() {
  if (!connected_ || under_way_ != nullptr || close_sent_) return;
  if (!answers_.empty()) {
    const SharedMessage next = answers_.front();
    answers_.pop_front();
    write(next);
  } else if (closing_) {
    close_sent_ = true;
    socket_.async_close(
        *closing_, [self = shared_from_this()](beast::error_code /*gone either way*/) { self->leave(); });
  } else if (std::exchange(control_due_, false)) {
    v1::ServerMessage message;
    *message.mutable_control() = control_state();
    write(serialised(message));
  } else if (std::exchange(scene_due_, false)) {
    v1::ServerMessage message;
    *message.mutable_scene() = scene_state(context_.desk.in_force());
    *message.mutable_scene()->mutable_default_scene() = scene_message(context_.desk.default_scene());
    write(serialised(message));
  } else if (std::exchange(view_due_, false)) {
    v1::ServerMessage message;
    *message.mutable_view() = context_.views.state(id_);
    message.mutable_view()->set_ended(std::exchange(view_ended_, {}));
    write(serialised(message));
  } else if (std::exchange(probe_due_, false)) {
    v1::ServerMessage message;
    *message.mutable_probe_status() = context_.probe.message();
    write(serialised(message));
  } else if (std::exchange(statistics_due_, false)) {
    write(statistics());
  } else if (waiting_.message != nullptr) {
    send_picture();
  } else if (open_ && needs_key_) {
    // Nothing newer may come for long, and the display is behind.
    if (auto begun = context_.hub.begin_anew(*this); !begun) unserved();
  }
}

void StreamSession::send_picture() {
  // Who changed the scene learns first which picture has it.
  const auto seen = std::ranges::find_if(changes_unseen_, [this](const SceneQuestion& question) {
    return question.view_id == waiting_.view_id && question.revision <= waiting_.scene_revision;
  });
  if (seen != changes_unseen_.end()) {
    v1::ServerMessage message;
    v1::SceneShown& shown = *message.mutable_scene_shown();
    shown.set_request_id(seen->request_id);
    shown.set_revision(seen->revision);
    shown.set_picture_id(waiting_.picture_id);
    shown.set_private_view(seen->view_id != 0);
    changes_unseen_.erase(seen);
    write(serialised(message));
    return;
  }
  picture_under_way_ = true;
  write(std::exchange(waiting_.message, nullptr));
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
  hello.set_session_id(id_);
  hello.set_role(static_cast<v1::Role>(visitor_->role));
  hello.set_name(name_);
  *hello.mutable_control() = control_state();
  add_scene_fields(hello);
  *hello.mutable_scene() = scene_state(context_.desk.in_force());
  *hello.mutable_default_scene() = scene_message(context_.desk.default_scene());
  return serialised(message);
}

v1::ControlState StreamSession::control_state() const {
  const ControlDesk::State& state = context_.control.state();
  v1::ControlState message;
  message.set_holder_session(state.holder.session);
  message.set_holder_name(state.holder.name);
  message.set_lapses_after_s(static_cast<double>(context_.control.lapse_ms()) / 1000);
  message.set_mine(context_.control.holds(id_));
  for (const ControlDesk::Party& party : state.asking) {
    v1::ControlState::Asking& asking = *message.add_asking();
    asking.set_session(party.session);
    asking.set_name(party.name);
  }
  return message;
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
