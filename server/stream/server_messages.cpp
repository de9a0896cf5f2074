// SPDX-License-Identifier: Apache-2.0
#include "server/stream/server_messages.hpp"

#include <random>

#include "proto/base/clock.hpp"
#include "proto/base/version.hpp"
#include "server/state/scene_message.hpp"
#include "server/stream/stream_protocol.hpp"

namespace fanlight {

std::uint64_t ServerMessages::random_id() {
  std::random_device bits;
  return std::uint64_t{bits()} << 32 | bits();
}

v1::ServerMessage ServerMessages::hello(const SessionIdentity& session) const {
  v1::ServerMessage message;
  v1::Hello& hello = *message.mutable_hello();
  hello.set_protocol_version(kProtocolVersion);
  hello.set_server_version(version());
  const ServerDescription& description = state_.description;
  const bool may_know = has_role(session.principal->role, kReadsSourcePath);
  hello.set_title(description.title);
  hello.set_source(may_know ? description.source : description.title);
  hello.set_device(description.device);
  hello.set_picture_width(description.picture_size.width);
  hello.set_picture_height(description.picture_size.height);
  for (const std::string& note : description.notes) hello.add_notes(note);
  hello.set_run_id(run_id_);
  hello.set_session_id(session.id);
  hello.set_role(static_cast<v1::Role>(session.principal->role));
  hello.set_name(session.name);
  *hello.mutable_control() = control_state(session.id);
  add_scene_fields(hello);
  add_looks(hello);
  add_presets(hello);
  *hello.mutable_scene() = scene_state(state_.scene_store.in_force());
  *hello.mutable_default_scene() = scene_message(state_.scene_store.default_scene());
  return message;
}

v1::ServerMessage ServerMessages::login_needed(const std::string& reason) {
  v1::ServerMessage message;
  message.mutable_login_needed()->set_message(
      reason.empty() ? "this server needs a token, expected a login with one made by `fanlight token add`"
                     : reason);
  return message;
}

v1::ServerMessage ServerMessages::error(const std::string& sentence) {
  v1::ServerMessage message;
  message.mutable_error()->set_message(sentence);
  return message;
}

v1::ServerMessage ServerMessages::control(std::uint64_t session) const {
  v1::ServerMessage message;
  *message.mutable_control() = control_state(session);
  return message;
}

v1::ServerMessage ServerMessages::scene(const std::string& withdrawn) const {
  v1::ServerMessage message;
  *message.mutable_scene() = scene_state(state_.scene_store.in_force());
  *message.mutable_scene()->mutable_default_scene() = scene_message(state_.scene_store.default_scene());
  for (const std::string& note : state_.description.notes) message.mutable_scene()->add_notes(note);
  message.mutable_scene()->set_withdrawn(withdrawn);
  return message;
}

v1::ServerMessage ServerMessages::view(std::uint64_t session, const std::string& ended) const {
  v1::ServerMessage message;
  *message.mutable_view() = state_.views.state(session);
  message.mutable_view()->set_ended(ended);
  return message;
}

v1::ServerMessage ServerMessages::probe_status() const {
  v1::ServerMessage message;
  *message.mutable_probe_status() = state_.probe.message();
  return message;
}

v1::ServerMessage ServerMessages::liveness() const {
  const PictureLiveness::Report& report = state_.liveness.report();
  v1::ServerMessage message;
  v1::Liveness& to = *message.mutable_liveness();
  to.set_state(static_cast<v1::Liveness::State>(report.state));
  to.set_cause(static_cast<v1::Liveness::Cause>(report.cause));
  to.set_origin(static_cast<v1::Liveness::Origin>(report.origin));
  to.set_sentence(report.sentence);
  to.set_scene_trouble(report.scene_trouble);
  to.set_age_s(report.age_s);
  to.set_pictures_per_second(report.pictures_per_second);
  to.set_limit_s(static_cast<double>(state_.liveness.limit_ns()) / 1e9);
  return message;
}

v1::ServerMessage ServerMessages::recording() const {
  v1::ServerMessage message;
  *message.mutable_recording() = state_.recording.message();
  return message;
}

v1::ServerMessage ServerMessages::replay() const {
  v1::ServerMessage message;
  *message.mutable_replay() = state_.replay.message();
  return message;
}

bool ServerMessages::add_measurements(v1::ServerMessage& message, std::uint64_t& known_revision) const {
  MeasurementStore::Part part = state_.measurements.part_after(known_revision);
  *message.mutable_measurements() = std::move(part.list);
  known_revision = part.revision;
  return part.more;
}

v1::ServerMessage ServerMessages::presets() const {
  v1::ServerMessage message;
  *message.mutable_presets() = state_.presets.message();
  return message;
}

v1::ServerMessage ServerMessages::cine() const {
  v1::ServerMessage message;
  *message.mutable_cine() = state_.cine.message();
  return message;
}

v1::ServerMessage ServerMessages::relay() const {
  v1::ServerMessage message;
  message.mutable_relay()->set_sending(state_.is_relayed());
  return message;
}

v1::ServerMessage ServerMessages::statistics(const OutgoingQueue::PictureCounts& pictures) const {
  const PipelineCounters& pipeline = state_.pipeline;
  v1::ServerMessage message;
  v1::Statistics& to = *message.mutable_statistics();
  to.set_server_time_ns(now_ns());
  const AcquisitionCounters& frames = pipeline.acquisition;
  frames.seq_lock.read([&] {
    to.set_frames_received(frames.frames_received.value());
    to.set_frames_lost(frames.frames_lost());
  });
  to.set_volumes_interpolated(frames.volumes_interpolated.value());
  to.set_mismatch_deg(frames.mismatch_deg.value());
  to.set_mismatch_left_deg(frames.mismatch_left_deg.value());
  to.set_mismatch_left_mm(frames.mismatch_left_m.value() * 1000);
  to.set_volumes_assembled(pipeline.ring.volumes_published.value());
  to.set_volumes_dropped(pipeline.ring.volumes_dropped.value());
  to.set_pass1_runs(pipeline.render.pass1_runs.value());
  to.set_pass2_runs(pipeline.render.pass2_runs.value());
  to.set_pictures_rendered(pipeline.render.pictures_finished.value());
  to.set_pictures_offered(pictures.offered);
  to.set_pictures_sent(pictures.sent);
  to.set_pictures_skipped(pictures.skipped);
  to.set_sessions(static_cast<std::uint32_t>(hub_.subscriber_count()));
  to.set_source_state(state_.probe.lost() ? "probe lost" : state_.source_state());
  return message;
}

v1::ServerMessage ServerMessages::scene_shown(const OutgoingQueue::ShownRequest& request,
                                              std::uint64_t picture_id) {
  v1::ServerMessage message;
  v1::SceneShown& shown = *message.mutable_scene_shown();
  shown.set_request_id(request.request_id);
  shown.set_revision(request.revision);
  shown.set_picture_id(picture_id);
  shown.set_private_view(request.view_id != 0);
  return message;
}

v1::ControlState ServerMessages::control_state(std::uint64_t session) const {
  const ControlLease::State& state = control_.state();
  v1::ControlState message;
  message.set_holder_session(state.holder.session);
  message.set_holder_name(state.holder.name);
  message.set_lapses_after_s(static_cast<double>(control_.lapse_ms()) / 1000);
  message.set_mine(control_.holds(session));
  for (const ControlLease::Party& party : state.asking) {
    v1::ControlState::Asking& asking = *message.add_asking();
    asking.set_session(party.session);
    asking.set_name(party.name);
  }
  return message;
}

SharedMessage serialised(const v1::ServerMessage& message) {
  return std::make_shared<const std::string>(message.SerializeAsString());
}

}  // namespace fanlight
