// SPDX-License-Identifier: Apache-2.0
#include "server/client/display_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fanlight {

namespace {

constexpr std::int64_t kSilenceNs = 2'000'000'000;  // the server sends a message once a second at least
constexpr std::int64_t kRefusalShownNs = 4'000'000'000;
constexpr double kUsualLimitS = 2;
constexpr double kOrbitDegPerHeight = 180;
constexpr double kLeastScale = 0.1;

/// Millimetres at this depth that cover as many pixels as one at the depth of the target; 1 without
/// perspective. The light may lie behind the eye: see view_geometry.ts of the page.
double scale_at(double depth_mm, const v1::Scene::Camera& camera, bool perspective) {
  if (!perspective) return 1;
  const double half_rad = camera.opening_deg() * std::numbers::pi / 360;
  const double eye_to_target_mm = camera.field_mm() / (2 * std::tan(half_rad));
  const double eye_to_plane_mm = eye_to_target_mm - camera.distance_mm();
  return std::max(kLeastScale, std::abs(depth_mm + eye_to_plane_mm) / eye_to_target_mm);
}

const v1::Error* refusal_of(const v1::ServerMessage& message) {
  switch (message.body_case()) {
    case v1::ServerMessage::kSceneReply:
      return message.scene_reply().has_refused() ? &message.scene_reply().refused() : nullptr;
    case v1::ServerMessage::kCineReply:
      return message.cine_reply().has_refused() ? &message.cine_reply().refused() : nullptr;
    case v1::ServerMessage::kStreamReply:
      return message.stream_reply().has_refused() ? &message.stream_reply().refused() : nullptr;
    case v1::ServerMessage::kError:
      return &message.error();
    default:
      return nullptr;
  }
}

}  // namespace

DisplayState::DisplayState(const v1::Hello& hello)
    : hello_(hello), scene_(hello.scene().scene()), in_force_(scene_) {}

void DisplayState::take(const v1::ServerMessage& message, std::int64_t now_ns) {
  heard_ns_ = now_ns;
  if (const v1::Error* const refused = refusal_of(message)) {
    refusal_ = refused->message();
    refused_ns_ = now_ns;
  }
  switch (message.body_case()) {
    case v1::ServerMessage::kLiveness:
      liveness_ = message.liveness();
      return;
    case v1::ServerMessage::kRelay:
      is_relayed_ = message.relay().sending();
      return;
    case v1::ServerMessage::kCine:
      cine_ = message.cine();
      return;
    case v1::ServerMessage::kScene:
      scene_ = in_force_ = message.scene().scene();
      if (!message.scene().withdrawn().empty()) {
        refusal_ = message.scene().withdrawn();
        refused_ns_ = now_ns;
      }
      return;
    case v1::ServerMessage::kSceneReply:
      if (message.scene_reply().has_in_force()) in_force_ = message.scene_reply().in_force().scene();
      // Else later changes of this display are on their way.
      if (message.scene_reply().request_id() == last_request_) scene_ = in_force_;
      return;
    case v1::ServerMessage::kStatistics: {
      const std::int64_t ahead_ns = message.statistics().server_time_ns() - now_ns;
      constexpr std::int64_t kForgottenPart = 1000;  // of the time since the last one
      const std::int64_t forgotten_ns = (now_ns - clock_told_ns_) / kForgottenPart;
      clock_ahead_ns_ = std::max(clock_ahead_ns_.value_or(ahead_ns) - forgotten_ns, ahead_ns);
      clock_told_ns_ = now_ns;
      return;
    }
    default:
      return;
  }
}

void DisplayState::shown(const v1::Picture& picture) {
  any_picture_ = true;
  volume_id_ = picture.volume_id();
  captured_ns_ = picture.capture_time_ns();
  if (picture.has_levels()) levels_ = picture.levels();
}

DisplayState::Condition DisplayState::condition(std::int64_t now_ns) const {
  const double age_s =
      clock_ahead_ns_ && any_picture_
          ? std::max(0.0, static_cast<double>(now_ns + *clock_ahead_ns_ - captured_ns_) / 1e9)
          : -1;
  const std::string age = age_s < 0 ? "" : fmt::format(" {:.1f} s", age_s);
  const auto lost = [&](const std::string& reason) {
    const std::string old = age.empty() ? "" : "," + age + " old";
    return any_picture_ ? Condition{.word = Word::kLost, .text = "LOST" + old, .reason = reason}
                        : Condition{.word = Word::kWaiting, .text = "WAITING", .reason = reason};
  };
  if (!lost_reason_.empty()) return lost(lost_reason_);
  if (heard_ns_ && now_ns - *heard_ns_ > kSilenceNs)
    return lost(fmt::format("The server has not answered for {} s.", (now_ns - *heard_ns_) / 1'000'000'000));
  const double limit_s = liveness_.limit_s() > 0 ? liveness_.limit_s() : kUsualLimitS;
  switch (liveness_.state()) {
    case v1::Liveness::FROZEN:
      return {.word = Word::kFrozen, .text = "FROZEN" + age, .reason = liveness_.sentence()};
    case v1::Liveness::NOT_LIVE:
      return lost(liveness_.sentence());
    case v1::Liveness::REPLAY:
      return {.word = Word::kReplay, .text = "REPLAY", .reason = liveness_.sentence()};
    case v1::Liveness::DELAYED:
      return {.word = Word::kDelayed, .text = "DELAYED" + age, .reason = liveness_.sentence()};
    default:
      break;
  }
  if (!any_picture_) return {.word = Word::kWaiting, .text = "WAITING", .reason = liveness_.sentence()};
  if (age_s > limit_s) {
    return {.word = Word::kDelayed, .text = "DELAYED" + age, .reason = "Pictures reach this display late."};
  }
  const bool is_plain = liveness_.cause() == v1::Liveness::NONE && liveness_.origin() == v1::Liveness::PROBE;
  const char* const live = liveness_.origin() == v1::Liveness::SIMULATED ? "SIMULATED"
                           : liveness_.origin() == v1::Liveness::UNKNOWN ? "LIVE, UNVERIFIED"
                                                                         : "LIVE";
  return {.word = Word::kLive, .text = live + age, .reason = is_plain ? "" : liveness_.sentence()};
}

std::string DisplayState::refusal(std::int64_t now_ns) const {
  return now_ns - refused_ns_ < kRefusalShownNs ? refusal_ : "";
}

const v1::SceneField* DisplayState::field(const std::string& name) const {
  const auto found = std::ranges::find(hello_.fields(), name, &v1::SceneField::name);
  return found == hello_.fields().end() ? nullptr : &*found;
}

bool DisplayState::is(const std::string& name, std::uint32_t index, const std::string& choice) const {
  const v1::SceneField* const known = field(name);
  const int place = static_cast<int>(index);
  return known != nullptr && place < known->choices_size() && known->choices(place) == choice;
}

DisplayState::Part DisplayState::surface_part() const {
  const double width = hello_.picture_width();
  const double height = hello_.picture_height();
  const double half_width = std::floor(width / 2);
  const double half_height = std::floor(height / 2);
  if (is("mode", scene_.mode(), "slices")) {
    return {.left = half_width,
            .top = half_height,
            .width = width - half_width,
            .height = height - half_height,
            .field_pixels = height - half_height};
  }
  // In this mode camera.field_mm covers the smaller side.
  if (is("mode", scene_.mode(), "surface-and-volume"))
    return {.width = half_width, .height = height, .field_pixels = std::min(half_width, height)};
  return {.width = width, .height = height, .field_pixels = height};
}

v1::ClientMessage DisplayState::changed(const v1::Scene& change) {
  scene_.MergeFrom(change);
  v1::ClientMessage message;
  message.mutable_scene_change()->set_request_id(++last_request_);
  *message.mutable_scene_change()->mutable_scene() = change;
  return message;
}

v1::ClientMessage DisplayState::turn(double right_px, double down_px) {
  const double deg_per_px = kOrbitDegPerHeight / surface_part().height;
  const double yaw_deg = scene_.camera().yaw_deg() - right_px * deg_per_px;
  v1::Scene change;
  change.mutable_camera()->set_yaw_deg(yaw_deg - 360 * std::round(yaw_deg / 360));
  change.mutable_camera()->set_pitch_deg(
      std::clamp(scene_.camera().pitch_deg() + down_px * deg_per_px, -90.0, 90.0));
  return changed(change);
}

v1::ClientMessage DisplayState::zoom(double factor) {
  v1::Scene change;
  change.mutable_camera()->set_field_mm(allowed("camera.field_mm", scene_.camera().field_mm() * factor));
  return changed(change);
}

double DisplayState::allowed(const std::string& name, double value) const {
  const v1::SceneField* const known = field(name);
  return known == nullptr ? value : std::clamp(value, known->minimum(), known->maximum());
}

v1::ClientMessage DisplayState::light_to(double column, double row) {
  const Part part = surface_part();
  const double mm_per_px = scene_.camera().field_mm() *
                           scale_at(scene_.light().depth_mm(), scene_.camera(),
                                    is("camera.projection", scene_.camera().projection(), "perspective")) /
                           part.field_pixels;
  v1::Scene change;
  change.mutable_light()->set_right_mm(
      allowed("light.right_mm", (column - part.left - part.width / 2) * mm_per_px));
  change.mutable_light()->set_up_mm(allowed("light.up_mm", (part.top + part.height / 2 - row) * mm_per_px));
  return changed(change);
}

v1::ClientMessage DisplayState::threshold_by(double levels) {
  constexpr double kLeast = 1;  // 0: measured
  const double now = scene_.detector().threshold() > 0 ? scene_.detector().threshold() : levels_.threshold();
  v1::Scene change;
  change.mutable_detector()->set_threshold(allowed("detector.threshold", std::max(kLeast, now + levels)));
  return changed(change);
}

std::optional<v1::ClientMessage> DisplayState::preset(int index) {
  if (index < 0 || index >= hello_.presets_size()) return std::nullopt;
  return changed(hello_.presets(index).scene());
}

std::string DisplayState::preset_name(int index) const {
  return index < 0 || index >= hello_.presets_size() ? "" : hello_.presets(index).name();
}

std::optional<v1::ClientMessage> DisplayState::mode(const std::string& name) {
  const v1::SceneField* const known = field("mode");
  if (known == nullptr) return std::nullopt;
  const auto choice = std::ranges::find(known->choices(), name);
  if (choice == known->choices().end()) return std::nullopt;
  v1::Scene change;
  change.set_mode(static_cast<std::uint32_t>(choice - known->choices().begin()));
  return changed(change);
}

v1::ClientMessage DisplayState::reset() {
  v1::Scene change;
  *change.mutable_camera() = hello_.default_scene().camera();
  return changed(change);
}

v1::ClientMessage DisplayState::freeze_or_live() const {
  v1::ClientMessage message;
  const bool live = cine_.state() == v1::CineStatus::LIVE;
  message.mutable_cine()->set_wish(live ? v1::CineRequest::FREEZE : v1::CineRequest::LIVE);
  if (live) message.mutable_cine()->set_volume_id(volume_id_);
  return message;
}

v1::ClientMessage DisplayState::step(int volumes) const {
  v1::ClientMessage message;
  message.mutable_cine()->set_wish(v1::CineRequest::STEP);
  message.mutable_cine()->set_value(volumes);
  return message;
}

}  // namespace fanlight
