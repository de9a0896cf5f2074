// SPDX-License-Identifier: Apache-2.0
#include "server/stream/stream_requests.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "server/state/scene_message.hpp"
#include "server/stream/picture_message.hpp"
#include "server/stream/preset_author.hpp"

namespace fanlight {

namespace websocket = boost::beast::websocket;

namespace {

constexpr std::size_t kMostPendingProbeChanges = 16;
constexpr int kMostDepthPixels = 1024;
constexpr std::size_t kLongestNameBytes = 64;

std::int64_t now_ms() {
  return now_ns() / 1'000'000;
}

/// Whether the text may appear on a page and in a log.
bool is_name(const std::string& text) {
  return text.size() <= kLongestNameBytes && is_printable(text);
}

}  // namespace

void StreamRequests::handle(const v1::ClientMessage& message) {
  if (!identity().principal && message.body_case() != v1::ClientMessage::kLogin) {
    refuse("this session has shown no token, expected a login first");
    return;
  }
  switch (message.body_case()) {
    case v1::ClientMessage::kLogin:
      return log_in(message.login());
    case v1::ClientMessage::kSceneChange:
      return change_scene(message.scene_change());
    case v1::ClientMessage::kClockRequest:
      return answer_clock(message.clock_request());
    case v1::ClientMessage::kProbeChange:
      return change_probe(message.probe_change());
    case v1::ClientMessage::kControl:
      return change_control(message.control());
    case v1::ClientMessage::kStream:
      return change_stream(message.stream());
    case v1::ClientMessage::kDepth:
      return answer_depth(message.depth());
    case v1::ClientMessage::kView:
      return change_view(message.view());
    case v1::ClientMessage::kSurvey:
      return find_surface(message.survey());
    case v1::ClientMessage::kRecording:
      return record(message.recording());
    case v1::ClientMessage::kReplay:
      return control_replay(message.replay());
    case v1::ClientMessage::kCine:
      return control_cine(message.cine());
    case v1::ClientMessage::kPreset:
      return change_presets(message.preset());
    case v1::ClientMessage::BODY_NOT_SET:
      return refuse("a message has no body that is known, expected one of fanlight.v1.ClientMessage");
  }
}

void StreamRequests::refuse(const std::string& sentence) {
  dependencies_.counters.messages_refused.add();
  answer(ServerMessages::error(sentence));
}

void StreamRequests::log_in(const v1::Login& login) {
  if (!is_name(login.name())) {
    return refuse(fmt::format("the name has letters that do not print or over {} bytes, expected another",
                              kLongestNameBytes));
  }
  if (identity().principal) {
    // The client is authenticated: the login only names the display.
    session_.set_name(login.name().empty() ? identity().principal->name : login.name());
    if (dependencies_.control.renamed(party())) dependencies_.sessions.control_changed();
    return;
  }
  const auto principal = dependencies_.access.by_token(login.token(), identity().address);
  if (principal) return session_.open(*principal, login.name());
  dependencies_.counters.logins_refused.add();
  refuse(principal.error().message);
  session_.close(websocket::close_code::policy_error, "the login was refused");
}

void StreamRequests::change_scene(const v1::SceneChange& change) {
  v1::ServerMessage message;
  v1::SceneReply& reply = *message.mutable_scene_reply();
  reply.set_request_id(change.request_id());
  const std::uint64_t holder = dependencies_.control.state().holder.session;
  const SceneField* refused = nullptr;
  Result<bool> applied = false;
  if (auto may = dependencies_.control.may_change(party(), role()); may) {
    applied = dependencies_.scene_store.apply(change.scene(), &refused);
  } else {
    applied = may.error();
  }
  if (applied) {
    // Only a change that was applied acquires control.
    (void)dependencies_.control.use(party(), role(), now_ms());
    dependencies_.counters.scene_changes.add();
    *reply.mutable_in_force() = scene_state(dependencies_.scene_store.in_force());
    queue_.add_shown_request(
        {.view_id = 0, .revision = reply.in_force().revision(), .request_id = change.request_id()});
    audit_.add_change(change.scene());
  } else {
    dependencies_.counters.scene_refusals.add();
    describe(*reply.mutable_refused(), applied.error(), refused);
    audit_.note("scene_change", "refused: " + applied.error().message);
  }
  answer(message);
  if (dependencies_.control.state().holder.session != holder) dependencies_.sessions.control_changed();
  if (applied && *applied) dependencies_.sessions.scene_changed(identity().id);
}

void StreamRequests::change_view(const v1::ViewChange& change) {
  v1::ServerMessage message;
  v1::ViewReply& reply = *message.mutable_view_reply();
  reply.set_request_id(change.request_id());
  if (change.leave()) return leave_view(message);
  const std::uint64_t id = identity().id;
  const bool had_view = dependencies_.views.has(id);
  const SceneField* refused = nullptr;
  if (auto changed = dependencies_.views.change(id, change.scene(), &refused, now_ns()); !changed) {
    dependencies_.counters.private_view_refusals.add();
    describe(*reply.mutable_refused(), changed.error(), refused);
    audit_.note("private_view", "refused: " + changed.error().message);
    return answer(message);
  }
  session_.forget_view_end();
  if (!had_view) audit_.note("private_view", "done");
  *reply.mutable_in_force() = dependencies_.views.state(id);
  answer(message);
  queue_.add_shown_request(
      {.view_id = id, .revision = dependencies_.views.revision(id), .request_id = change.request_id()});
}

void StreamRequests::leave_view(v1::ServerMessage& message) {
  const std::uint64_t id = identity().id;
  const bool had_view = dependencies_.views.leave(id);
  *message.mutable_view_reply()->mutable_in_force() = dependencies_.views.state(id);
  answer(message);
  if (!had_view) return;
  audit_.note("private_view", "left");
  dependencies_.hub.forget_view(session_);
}

Result<std::uint64_t> StreamRequests::order_of_probe(const v1::ProbeSettings& settings) {
  if (auto may = dependencies_.control.may_change(party(), role()); !may) return may.error();
  // The answer comes later, and the session must be able to read meanwhile.
  if (pending_probe_changes_.size() >= kMostPendingProbeChanges) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} changes of the probe are unanswered, expected some patience",
                             kMostPendingProbeChanges)};
  }
  return dependencies_.probe.order(settings);
}

void StreamRequests::change_probe(const v1::ProbeChange& change) {
  const auto order = order_of_probe(change.settings());
  if (order) {
    // Only an order that was given acquires control; it is free again where the probe refuses.
    const bool held = dependencies_.control.holds(identity().id);
    (void)dependencies_.control.use(party(), role(), now_ms());
    pending_probe_changes_.push_back(
        {.order = *order, .request_id = change.request_id(), .acquired_control = !held});
    if (!held) dependencies_.sessions.control_changed();
    return;
  }
  dependencies_.counters.probe_refusals.add();
  audit_.note("probe_change", "refused: " + order.error().message);
  v1::ServerMessage message;
  message.mutable_probe_reply()->set_request_id(change.request_id());
  message.mutable_probe_reply()->mutable_refused()->set_message(order.error().message);
  answer(message);
}

void StreamRequests::answer_probe_changes() {
  const ProbeStatus& status = dependencies_.probe.status();
  while (!pending_probe_changes_.empty() && pending_probe_changes_.front().order <= status.order_answered) {
    v1::ServerMessage message;
    v1::ProbeReply& reply = *message.mutable_probe_reply();
    const PendingProbeChange change = pending_probe_changes_.front();
    reply.set_request_id(change.request_id);
    pending_probe_changes_.pop_front();
    if (status.refusal.empty()) {
      dependencies_.counters.probe_changes.add();
      *reply.mutable_in_force() = settings_message(status.settings);
      audit_.note("probe_change", "done");
    } else {
      dependencies_.counters.probe_refusals.add();
      reply.mutable_refused()->set_message(status.refusal);
      audit_.note("probe_change", "refused: " + status.refusal);
      if (change.acquired_control && dependencies_.control.release(identity().id, now_ms()))
        dependencies_.sessions.control_changed();
    }
    answer(message);
  }
}

void StreamRequests::find_surface(const v1::SurveyRequest& request) {
  auto wished = dependencies_.control.may_change(party(), role());
  if (wished) {
    wished = dependencies_.surveys.wish(identity().id, request.request_id(),
                                        dependencies_.scene_store.in_force().scene);
  }
  if (wished) return;  // the answer comes when the render thread has looked
  v1::ServerMessage message;
  message.mutable_survey_reply()->set_request_id(request.request_id());
  message.mutable_survey_reply()->mutable_refused()->set_message(wished.error().message);
  answer(message);
}

void StreamRequests::record(const v1::RecordingRequest& request) {
  v1::ServerMessage message;
  v1::RecordingReply& reply = *message.mutable_recording_reply();
  reply.set_request_id(request.request_id());
  Result<std::string> file = Error{ErrorCode::kInvalidArgument, "wish: expected START, STOP or KEEP"};
  const bool known = v1::RecordingRequest::Wish_IsValid(request.wish());
  const std::string word(known ? recording_word(static_cast<RecordingWish>(request.wish())) : "unknown");
  if (const auto may = dependencies_.control.may_change(party(), role()); !may) {
    file = may.error();
  } else if (known) {
    file = dependencies_.recording.request(static_cast<RecordingWish>(request.wish()));
  }
  if (file) {
    reply.set_file(*file);
    audit_.note("recording", "done", {{"wish", word}, {"file", *file}});
  } else {
    dependencies_.counters.recording_refusals.add();
    reply.mutable_refused()->set_message(file.error().message);
    audit_.note("recording", "refused: " + file.error().message, {{"wish", word}});
  }
  answer(message);
}

template <typename Proxy, typename Request, typename Reply>
void StreamRequests::carry_out(Proxy& proxy, const Request& request, Reply& reply, Counter& refusals) {
  reply.set_request_id(request.request_id());
  const auto may = dependencies_.control.may_change(party(), role());
  const Result<void> done = may ? proxy.request(request) : may;
  if (done) {
    reply.set_taken(true);
  } else {
    refusals.add();
    reply.mutable_refused()->set_message(done.error().message);
  }
}

void StreamRequests::control_replay(const v1::ReplayRequest& request) {
  v1::ServerMessage message;
  v1::ReplayReply& reply = *message.mutable_replay_reply();
  carry_out(dependencies_.replay, request, reply, dependencies_.counters.replay_refusals);
  audit_.note("replay", reply.has_refused() ? "refused: " + reply.refused().message() : "done",
              {{"wish", replay_words(request)}});
  answer(message);
}

void StreamRequests::control_cine(const v1::CineRequest& request) {
  v1::ServerMessage message;
  v1::CineReply& reply = *message.mutable_cine_reply();
  carry_out(dependencies_.cine, request, reply, dependencies_.counters.cine_refusals);
  audit_.note("cine", reply.has_refused() ? "refused: " + reply.refused().message() : "done",
              {{"wish", cine_words(request)}});
  answer(message);
}

void StreamRequests::change_presets(const v1::PresetRequest& request) {
  v1::ServerMessage message;
  v1::PresetReply& reply = *message.mutable_preset_reply();
  reply.set_request_id(request.request_id());
  const Result<void> done =
      role() == Role::kViewer
          ? Error{ErrorCode::kUnavailable, "a viewer saves no presets, expected the role of an operator"}
          : dependencies_.presets.request(request, scene_message(dependencies_.scene_store.in_force().scene),
                                          preset_author(*identity().principal));
  if (done) {
    reply.set_done(true);
  } else {
    dependencies_.counters.preset_refusals.add();
    reply.mutable_refused()->set_message(done.error().message);
  }
  audit_.note("preset", done ? "done" : "refused: " + done.error().message,
              {{request.has_remove() ? "remove" : "save",
                printable(request.has_remove() ? request.remove() : request.save().name())}});
  answer(message);
}

Result<bool> StreamRequests::apply_wish(const v1::ControlRequest& request) {
  const std::uint64_t id = identity().id;
  switch (request.wish()) {
    case v1::ControlRequest::ASK:
      return dependencies_.control.ask(party(), role(), now_ms());
    case v1::ControlRequest::RELEASE:
      return dependencies_.control.release(id, now_ms());
    case v1::ControlRequest::GRANT:
      return dependencies_.control.grant(id, request.to_session(), now_ms());
    case v1::ControlRequest::TAKE_OVER:
      return dependencies_.control.take_over(party(), role(), now_ms());
    case v1::ControlRequest::KEEP:
      return dependencies_.control.keep(id, now_ms());
    default:
      return Error{ErrorCode::kInvalidArgument, "wish: expected ASK, RELEASE, GRANT, TAKE_OVER or KEEP"};
  }
}

void StreamRequests::change_control(const v1::ControlRequest& request) {
  v1::ServerMessage message;
  v1::ControlReply& reply = *message.mutable_control_reply();
  reply.set_request_id(request.request_id());
  const auto done = apply_wish(request);
  if (done) {
    *reply.mutable_state() = dependencies_.messages.control_state(identity().id);
  } else {
    dependencies_.counters.control_refusals.add();
    reply.mutable_refused()->set_message(done.error().message);
  }
  answer(message);
  if (request.wish() == v1::ControlRequest::KEEP && done) return;  // frequent, and changes nothing to report
  audit_.note("control", done ? "done" : "refused: " + done.error().message,
              {{"wish", v1::ControlRequest::Wish_Name(request.wish())},
               {"in_control", dependencies_.control.state().holder.session}});
  if (done) dependencies_.sessions.control_changed();
}

Result<void> StreamRequests::may_change_stream(const StreamSettings& settings) {
  if (!budget_.take_stream_change()) {
    return Error{ErrorCode::kUnavailable,
                 "the stream was changed several times within a second, expected some patience"};
  }
  return dependencies_.hub.has_room(session_, settings);
}

void StreamRequests::change_stream(const v1::StreamRequest& request) {
  v1::ServerMessage message;
  v1::StreamReply& reply = *message.mutable_stream_reply();
  reply.set_request_id(request.request_id());
  auto settings = parse_stream_request(request, dependencies_.jpeg_quality);
  const bool other = settings && *settings != session_.settings();
  if (other) {
    if (auto may = may_change_stream(*settings); !may) settings = may.error();
  }
  if (!settings) {
    dependencies_.counters.messages_refused.add();
    reply.mutable_refused()->set_message(settings.error().message);
    return answer(message);
  }
  *reply.mutable_in_force() = stream_message(*settings);
  answer(message);
  if (!other) return;
  session_.set_settings(*settings);
  dependencies_.hub.resync(session_);
}

void StreamRequests::answer_clock(const v1::ClockRequest& request) {
  v1::ServerMessage message;
  message.mutable_clock_reply()->set_client_time_ms(request.client_time_ms());
  message.mutable_clock_reply()->set_server_time_ns(now_ns());
  answer(message);
}

void StreamRequests::answer_depth(const v1::DepthRequest& request) {
  v1::ServerMessage message;
  v1::DepthReply& reply = *message.mutable_depth_reply();
  reply.set_request_id(request.request_id());
  const Picture* const picture = dependencies_.hub.newest_picture(session_.view_id());
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
