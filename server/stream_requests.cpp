// What a display asks for: logins, changes of the scene, the probe, the control and its own stream.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "proto/clock.hpp"
#include "server/picture_message.hpp"
#include "server/scene_json.hpp"
#include "server/scene_message.hpp"
#include "server/stream_session.hpp"

namespace fanlight {

namespace websocket = boost::beast::websocket;

namespace {

constexpr std::size_t kMostQuestions = 16;
constexpr int kMostDepthPixels = 1024;
constexpr std::size_t kLongestNameBytes = 64;

std::int64_t now_ms() {
  return now_ns() / 1'000'000;
}

/// Something that can stand on a page and in a log.
bool is_name(const std::string& text) {
  return text.size() <= kLongestNameBytes &&
         std::ranges::none_of(text, [](unsigned char letter) { return letter < 32 || letter == 127; });
}

}  // namespace

void StreamSession::handle(const v1::ClientMessage& message) {
  if (!open_ && message.body_case() != v1::ClientMessage::kLogin) {
    refuse("this session has shown no token, expected a login first");
    return;
  }
  switch (message.body_case()) {
    case v1::ClientMessage::kLogin:
      return log_in(message.login());
    case v1::ClientMessage::kSceneChange:
      return change_scene(message.scene_change());
    case v1::ClientMessage::kClockRequest: {
      v1::ServerMessage reply;
      reply.mutable_clock_reply()->set_client_time_ms(message.clock_request().client_time_ms());
      reply.mutable_clock_reply()->set_server_time_ns(now_ns());
      return answer(reply);
    }
    case v1::ClientMessage::kProbeChange:
      return change_probe(message.probe_change());
    case v1::ClientMessage::kControl:
      return change_control(message.control());
    case v1::ClientMessage::kStream:
      return change_stream(message.stream());
    case v1::ClientMessage::kDepth:
      return tell_depth(message.depth());
    case v1::ClientMessage::kView:
      return change_view(message.view());
    case v1::ClientMessage::BODY_NOT_SET:
      return refuse("a message has no body that is known, expected one of fanlight.v1.ClientMessage");
  }
}

void StreamSession::log_in(const v1::Login& login) {
  if (!is_name(login.name())) {
    return refuse(fmt::format("the name has letters that do not print or over {} bytes, expected another",
                              kLongestNameBytes));
  }
  if (open_) {
    // Where no token is needed a login gives the display its name.
    name_ = login.name().empty() ? visitor_->name : login.name();
    if (context_.control.renamed(party())) tell_of_control(context_);
    return;
  }
  auto visitor = context_.access.by_token(login.token(), address_);
  if (visitor) return enter(std::move(*visitor), login.name());
  refuse(visitor.error().message);
  close(websocket::close_code::policy_error, "the login was refused");
}

void StreamSession::change_scene(const v1::SceneChange& change) {
  v1::ServerMessage message;
  v1::SceneReply& reply = *message.mutable_scene_reply();
  reply.set_request_id(change.request_id());
  const std::uint64_t holder = context_.control.state().holder.session;
  const SceneField* refused = nullptr;
  Result<bool> applied = false;
  if (auto may = context_.control.may_change(party(), visitor_->role); may) {
    applied = context_.desk.apply(change.scene(), &refused);
  } else {
    applied = may.error();
  }
  // What was refused takes no control.
  if (applied) (void)context_.control.use(party(), visitor_->role, now_ms());
  if (applied) {
    context_.counters.scene_changes.add();
    *reply.mutable_in_force() = scene_state(context_.desk.in_force());
    ask_when_shown(
        {.view_id = 0, .revision = reply.in_force().revision(), .request_id = change.request_id()});
    changes_unaudited_.MergeFrom(change.scene());
    ++changes_unaudited_count_;
  } else {
    context_.counters.scene_refusals.add();
    describe(*reply.mutable_refused(), applied.error(), refused);
    audit("scene_change", "refused: " + applied.error().message);
  }
  answer(message);
  if (context_.control.state().holder.session != holder) tell_of_control(context_);
  if (applied && *applied) tell_of_scene(context_, id_);
}

void StreamSession::ask_when_shown(const SceneQuestion& question) {
  if (changes_unseen_.size() >= kMostQuestions) changes_unseen_.pop_front();
  changes_unseen_.push_back(question);
}

void StreamSession::change_view(const v1::ViewChange& change) {
  v1::ServerMessage message;
  v1::ViewReply& reply = *message.mutable_view_reply();
  reply.set_request_id(change.request_id());
  const bool had = context_.views.has(id_);
  if (change.leave()) {
    context_.views.leave(id_);
    *reply.mutable_in_force() = context_.views.state(id_);
    answer(message);
    if (!had) return;
    audit_at_will("private_view", "left");
    return context_.hub.forget_view(*this);
  }
  const SceneField* refused = nullptr;
  if (auto changed = context_.views.change(id_, change.scene(), &refused); !changed) {
    context_.counters.private_view_refusals.add();
    describe(*reply.mutable_refused(), changed.error(), refused);
    audit("private_view", "refused: " + changed.error().message);
    return answer(message);
  }
  view_ended_.clear();  // what ended is open again
  if (!had) audit_at_will("private_view", "done");
  *reply.mutable_in_force() = context_.views.state(id_);
  answer(message);
  ask_when_shown(
      {.view_id = id_, .revision = context_.views.revision(id_), .request_id = change.request_id()});
}

void StreamSession::change_probe(const v1::ProbeChange& change) {
  const std::uint64_t holder = context_.control.state().holder.session;
  const auto may = context_.control.use(party(), visitor_->role, now_ms());
  if (context_.control.state().holder.session != holder) tell_of_control(context_);
  // They wait for the probe, and the session must go on reading meanwhile.
  const bool room = probe_questions_.size() < kMostQuestions;
  const auto order = !may ? may.error()
                     : room
                         ? context_.probe.order(change.settings())
                         : Error{ErrorCode::kUnavailable,
                                 fmt::format("{} changes of the probe are unanswered, expected some patience",
                                             kMostQuestions)};
  if (order) {
    probe_questions_.push_back({.order = *order, .request_id = change.request_id()});
    return;
  }
  context_.counters.probe_refusals.add();
  audit("probe_change", "refused: " + order.error().message);
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
      audit("probe_change", "done");
    } else {
      context_.counters.probe_refusals.add();
      reply.mutable_refused()->set_message(status.refusal);
      audit("probe_change", "refused: " + status.refusal);
    }
    answer(message);
  }
}

Result<bool> StreamSession::wish(const v1::ControlRequest& request) {
  switch (request.wish()) {
    case v1::ControlRequest::ASK:
      return context_.control.ask(party(), visitor_->role, now_ms());
    case v1::ControlRequest::RELEASE:
      return context_.control.release(id_, now_ms());
    case v1::ControlRequest::GRANT:
      return context_.control.grant(id_, request.to_session(), now_ms());
    case v1::ControlRequest::TAKE_OVER:
      return context_.control.take_over(party(), visitor_->role, now_ms());
    case v1::ControlRequest::KEEP:
      return context_.control.keep(id_, now_ms());
    default:
      return Error{ErrorCode::kInvalidArgument, "wish: expected ASK, RELEASE, GRANT, TAKE_OVER or KEEP"};
  }
}

void StreamSession::change_control(const v1::ControlRequest& request) {
  v1::ServerMessage message;
  v1::ControlReply& reply = *message.mutable_control_reply();
  reply.set_request_id(request.request_id());
  const auto done = wish(request);
  if (done) {
    *reply.mutable_state() = control_state();
  } else {
    context_.counters.control_refusals.add();
    reply.mutable_refused()->set_message(done.error().message);
  }
  answer(message);
  if (request.wish() == v1::ControlRequest::KEEP && done) return;  // many, and nothing new
  context_.audit.note_refusal(  // also what is granted: it can be asked for as often
      *visitor_,
      {.what = "control", .session = id_, .result = done ? "done" : "refused: " + done.error().message},
      {{"wish", v1::ControlRequest::Wish_Name(request.wish())},
       {"in_control", context_.control.state().holder.session}});
  if (done) tell_of_control(context_);
}

void StreamSession::change_stream(const v1::StreamRequest& request) {
  v1::ServerMessage message;
  v1::StreamReply& reply = *message.mutable_stream_reply();
  reply.set_request_id(request.request_id());
  auto settings = parse_stream_request(request, context_.facts.jpeg_quality);
  const bool other = settings && *settings != settings_;
  if (other && stream_changes_left_-- <= 0) {
    settings = Error{ErrorCode::kUnavailable,
                     "the stream was changed several times within a second, expected some patience"};
  } else if (other) {
    if (auto room = context_.hub.has_room(view_id_, *settings); !room) settings = room.error();
  }
  if (!settings) {
    context_.counters.messages_refused.add();
    reply.mutable_refused()->set_message(settings.error().message);
    return answer(message);
  }
  *reply.mutable_in_force() = stream_message(*settings);
  answer(message);
  if (!other) return;
  settings_ = *settings;
  skip_waiting();
  needs_key_ = settings_.codec == StreamSettings::Codec::kH264;
  if (auto begun = context_.hub.begin_anew(*this); !begun) unserved();
}

void StreamSession::tell_depth(const v1::DepthRequest& request) {
  v1::ServerMessage message;
  v1::DepthReply& reply = *message.mutable_depth_reply();
  reply.set_request_id(request.request_id());
  const Picture* const picture = context_.hub.on_show(view_id_);
  if (request.pixels_size() > kMostDepthPixels) {
    reply.mutable_refused()->set_message(fmt::format("{} pixels were asked for, expected at most {}",
                                                     request.pixels_size(), kMostDepthPixels));
  } else if (picture == nullptr) {
    reply.mutable_refused()->set_message("there is no picture yet, expected some patience");
  } else {
    reply.set_picture_id(picture->stamp.picture_id);
    for (const v1::DepthRequest::Pixel& pixel : request.pixels()) {
      *reply.add_points() = point_at(*picture, pixel.column(), pixel.row());
    }
  }
  answer(message);
}

}  // namespace fanlight
