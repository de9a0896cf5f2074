// SPDX-License-Identifier: Apache-2.0
#include "server/stream/stream_requests.hpp"

#include <fmt/format.h>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "server/state/scene_message.hpp"
#include "server/stream/picture_message.hpp"

namespace fanlight {

namespace websocket = boost::beast::websocket;

namespace {

constexpr int kMostDepthPixels = 1024;

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
    case v1::ClientMessage::kFluid:
      return measure_fluid(message.fluid());
    case v1::ClientMessage::kRecording:
      return record(message.recording());
    case v1::ClientMessage::kReplay:
      return control_replay(message.replay());
    case v1::ClientMessage::kCine:
      return control_cine(message.cine());
    case v1::ClientMessage::kPreset:
      return change_presets(message.preset());
    case v1::ClientMessage::kMeasurement:
      return change_measurements(message.measurement());
    case v1::ClientMessage::BODY_NOT_SET:
      return refuse("a message has no body that is known, expected one of fanlight.v1.ClientMessage");
  }
}

void StreamRequests::refuse(const std::string& sentence) {
  dependencies_.state.counters.messages_refused.add();
  answer(ServerMessages::error(sentence));
}

void StreamRequests::log_in(const v1::Login& login) {
  if (!is_session_name(login.name())) {
    return refuse(fmt::format("the name has letters that do not print or over {} bytes, expected another",
                              kLongestNameBytes));
  }
  if (identity().principal) {
    // The client is authenticated: the login only names the display.
    session_.set_name(login.name().empty() ? identity().principal->name : login.name());
    if (dependencies_.control.renamed(identity().party())) dependencies_.sessions.notify(Notice::kControl);
    return;
  }
  const auto principal = dependencies_.access.by_token(login.token(), identity().address);
  if (principal) return session_.open(*principal, login.name());
  dependencies_.state.counters.logins_refused.add();
  refuse(principal.error().message);
  session_.close(websocket::close_code::policy_error, "the login was refused");
}

template <typename Reply, typename Done>
void StreamRequests::execute(const ClientCommand& command, std::uint64_t request_id,
                             Reply* (v1::ServerMessage::*reply_of)(), Done done) {
  const auto answer = [this, request_id, reply_of, done](const CommandResult& result) {
    session_.send([&] {
      v1::ServerMessage message;
      Reply& reply = *(message.*reply_of)();
      reply.set_request_id(request_id);
      if (result) {
        done(reply, result);
      } else {
        describe(*reply.mutable_refused(), result.error, result.field);
      }
      return message;
    });
  };
  dependencies_.commands.execute({.identity = identity(), .audit = audit_}, command, answer);
}

void StreamRequests::change_scene(const v1::SceneChange& change) {
  execute(ChangeScene{change.scene()}, change.request_id(), &v1::ServerMessage::mutable_scene_reply,
          [this](v1::SceneReply& reply, const CommandResult&) {
            *reply.mutable_in_force() = scene_state(dependencies_.state.scene_store.in_force());
            queue_.add_shown_request(
                {.view_id = 0, .revision = reply.in_force().revision(), .request_id = reply.request_id()});
          });
}

void StreamRequests::change_view(const v1::ViewChange& change) {
  if (change.leave()) return leave_view(change.request_id());
  execute(ChangeView{change.scene()}, change.request_id(), &v1::ServerMessage::mutable_view_reply,
          [this](v1::ViewReply& reply, const CommandResult&) {
            const ViewAdmission& views = dependencies_.state.views;
            const std::uint64_t id = identity().id;
            session_.forget_view_end();
            *reply.mutable_in_force() = views.state(id);
            queue_.add_shown_request(
                {.view_id = id, .revision = views.revision(id), .request_id = reply.request_id()});
          });
}

void StreamRequests::leave_view(std::uint64_t request_id) {
  bool had_view = false;
  execute(LeaveView(), request_id, &v1::ServerMessage::mutable_view_reply,
          [this, &had_view](v1::ViewReply& reply, const CommandResult& result) {
            had_view = result.view_ended;
            *reply.mutable_in_force() = dependencies_.state.views.state(identity().id);
          });
  if (had_view) dependencies_.hub.forget_view(session_);
}

void StreamRequests::change_probe(const v1::ProbeChange& change) {
  execute(ChangeProbe{change.settings()}, change.request_id(), &v1::ServerMessage::mutable_probe_reply,
          [this](v1::ProbeReply& reply, const CommandResult&) {
            *reply.mutable_in_force() = settings_message(dependencies_.state.probe.status().settings);
          });
}

void StreamRequests::find_surface(const v1::SurveyRequest& request) {
  execute(FindSurface(), request.request_id(), &v1::ServerMessage::mutable_survey_reply,
          [](v1::SurveyReply& reply, const CommandResult& result) { *reply.mutable_found() = result.found; });
}

void StreamRequests::measure_fluid(const v1::FluidRequest& request) {
  const MeasureFluid command{{.volume_id = request.volume_id(),
                              .at = {request.x_mm(), request.y_mm(), request.z_mm()},
                              .border_db = request.border_db()}};
  execute(command, request.request_id(), &v1::ServerMessage::mutable_fluid_reply,
          [this](v1::FluidReply& reply, const CommandResult& result) {
            found_region_ = result.region;
            *reply.mutable_found() = result.region;
          });
}

void StreamRequests::record(const v1::RecordingRequest& request) {
  ControlRecorder command;
  if (v1::RecordingRequest::Wish_IsValid(request.wish()))
    command.wish = static_cast<RecordingWish>(request.wish());
  execute(command, request.request_id(), &v1::ServerMessage::mutable_recording_reply,
          [](v1::RecordingReply& reply, const CommandResult& result) { reply.set_file(result.file); });
}

void StreamRequests::control_replay(const v1::ReplayRequest& request) {
  execute(ControlReplay{request}, request.request_id(), &v1::ServerMessage::mutable_replay_reply,
          [](v1::ReplayReply& reply, const CommandResult&) { reply.set_taken(true); });
}

void StreamRequests::control_cine(const v1::CineRequest& request) {
  execute(ControlCine{request}, request.request_id(), &v1::ServerMessage::mutable_cine_reply,
          [](v1::CineReply& reply, const CommandResult&) { reply.set_taken(true); });
}

void StreamRequests::change_presets(const v1::PresetRequest& request) {
  execute(ChangePresets{request}, request.request_id(), &v1::ServerMessage::mutable_preset_reply,
          [](v1::PresetReply& reply, const CommandResult&) { reply.set_done(true); });
}

void StreamRequests::change_measurements(const v1::MeasurementRequest& request) {
  ChangeMeasurements command{request};
  const bool takes_region = request.has_add() && request.with_region() && !found_region_.depths().empty();
  if (takes_region) *command.request.mutable_add()->mutable_region() = found_region_;
  execute(command, request.request_id(), &v1::ServerMessage::mutable_measurement_reply,
          [](v1::MeasurementReply& reply, const CommandResult&) { reply.set_done(true); });
}

void StreamRequests::change_control(const v1::ControlRequest& request) {
  execute(ChangeControl{.wish = request.wish(), .to_session = request.to_session()}, request.request_id(),
          &v1::ServerMessage::mutable_control_reply, [this](v1::ControlReply& reply, const CommandResult&) {
            *reply.mutable_state() = dependencies_.messages.control_state(identity().id);
          });
}

Result<void> StreamRequests::may_change_stream(const StreamSettings& settings) {
  if (!budget_.take_stream_change()) {
    return Error{ErrorCode::kUnavailable,
                 "the stream was changed several times within a second, expected a later request"};
  }
  return dependencies_.hub.has_room(session_, settings);
}

void StreamRequests::change_stream(const v1::StreamRequest& request) {
  v1::ServerMessage message;
  v1::StreamReply& reply = *message.mutable_stream_reply();
  reply.set_request_id(request.request_id());
  auto settings = parse_stream_request(request, dependencies_.state.description.jpeg_quality);
  if (settings) {
    if (auto may = may_change_stream(*settings); !may) settings = may.error();
  }
  if (!settings) {
    dependencies_.state.counters.messages_refused.add();
    reply.mutable_refused()->set_message(settings.error().message);
    return answer(message);
  }
  *reply.mutable_in_force() = stream_message(*settings);
  answer(message);
  // Also where they are the same: the display has lost a picture.
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
    reply.mutable_refused()->set_message(fmt::format("{} pixels were requested, expected at most {}",
                                                     request.pixels_size(), kMostDepthPixels));
  } else if (picture == nullptr) {
    reply.mutable_refused()->set_message("there is no picture yet, expected a later request");
  } else {
    reply.set_picture_id(picture->stamp.picture_id);
    const PictureSize usual = dependencies_.state.description.picture_size;
    const PictureSize counted{.width = request.width() > 0 ? request.width() : usual.width,
                              .height = request.height() > 0 ? request.height() : usual.height};
    for (const v1::DepthRequest::Pixel& pixel : request.pixels()) {
      *reply.add_points() = point_at(*picture, counted, pixel.column(), pixel.row());
    }
  }
  answer(message);
}

}  // namespace fanlight
