#include "server/picture_hub.hpp"

#include "proto/fan_geometry.hpp"
#include "proto/fanlight.pb.h"
#include "server/stream_session.hpp"

namespace fanlight {

namespace {

void describe(v1::Picture& message, const Picture& picture) {
  const PictureStamp& stamp = picture.stamp;
  message.set_picture_id(stamp.picture_id);
  message.set_volume_id(stamp.volume.volume_id);
  message.set_first_frame_sequence(stamp.volume.first_frame_sequence);
  message.set_last_frame_sequence(stamp.volume.last_frame_sequence);
  message.set_capture_time_ns(stamp.volume.last_capture_time_ns);
  message.set_finished_time_ns(stamp.finished_time_ns);
  message.set_scene_revision(stamp.scene_revision);
  message.set_pass1_runs(stamp.pass1_runs);
  message.set_pass2_runs(stamp.pass2_runs);
  message.set_frames_missing(stamp.volume.frames_missing);
  message.set_angle_correction_deg(degrees(stamp.volume.angle_correction_rad));
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    v1::StageTime& time = *message.add_stages();
    time.set_name(std::string(kStageNames[stage]));
    time.set_milliseconds(stamp.stage_ms[stage]);
  }
  message.set_deadline_level(stamp.deadline_level);
  const DeadlineMeasures& measures = stamp.measures;
  if (measures.coarse) message.add_measures("coarse picture");
  if (measures.wide_step) message.add_measures("wide step");
  if (measures.cheap_filters) message.add_measures("cheap filters");
  message.set_width(picture.width);
  message.set_height(picture.height);
}

}  // namespace

Result<void> PictureHub::encode() {
  const auto jpeg = encoder_.encode(*on_show_);
  if (!jpeg) return jpeg.error();
  v1::ServerMessage message;
  describe(*message.mutable_picture(), *on_show_);
  message.mutable_picture()->set_jpeg(jpeg->data(), jpeg->size());
  message_ = std::make_shared<const std::string>(message.SerializeAsString());
  counters_.pictures_encoded.add();
  return {};
}

Result<void> PictureHub::show(const Picture& picture) {
  on_show_ = &picture;
  message_ = nullptr;
  if (sessions_.empty()) return {};
  if (auto encoded = encode(); !encoded) return encoded;
  for (StreamSession* session : sessions_) session->offer(message_);
  return {};
}

Result<void> PictureHub::add(StreamSession& session) {
  sessions_.insert(&session);
  if (on_show_ == nullptr) return {};
  if (message_ == nullptr) {
    if (auto encoded = encode(); !encoded) return encoded;
  }
  session.offer(message_);
  return {};
}

}  // namespace fanlight
