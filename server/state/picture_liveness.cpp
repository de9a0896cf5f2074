// SPDX-License-Identifier: Apache-2.0
#include "server/state/picture_liveness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace fanlight {

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kLeastLimitNs = 2 * kSecondNs;
constexpr std::int64_t kSweepsOfALivePicture = 3;
// Pictures over which the rate is measured.
constexpr std::size_t kRatePictures = 8;

bool has_device(const RenderHealth& health) {
  return health.state == RenderHealth::State::kRunning || health.state == RenderHealth::State::kSlow;
}

double seconds(std::int64_t duration_ns) {
  return static_cast<double>(duration_ns) / kSecondNs;
}

}  // namespace

PictureLiveness::PictureLiveness(const PipelineCounters& pipeline, std::int64_t start_ns)
    : pipeline_(pipeline), progressed_ns_(start_ns) {
  frames_.grown_ns = volumes_.grown_ns = dropped_.grown_ns = refused_.grown_ns = start_ns;
}

const char* PictureLiveness::name(State state) {
  static constexpr auto kNames =
      std::to_array({"waiting", "live", "delayed", "not live", "replay", "frozen", "resting"});
  static_assert(kNames.size() == kStates);
  const auto index = static_cast<std::size_t>(state);
  return index < kNames.size() ? kNames[index] : "not live";  // a newer server may send a state of its own
}

const char* PictureLiveness::name(Cause cause) {
  static constexpr auto kNames =
      std::to_array({"none", "source failed", "source ended", "probe lost", "GPU lost", "GPU hangs",
                     "no frames", "volumes refused", "renderer behind", "sweeps dropped", "no sweep",
                     "driver silent", "change not shown"});
  static_assert(kNames.size() == kCauses);
  return kNames[static_cast<std::size_t>(cause)];
}

void PictureLiveness::Growth::see(std::uint64_t value, std::int64_t now_ns) {
  if (value == count) return;
  count = value;
  grown_ns = now_ns;
}

void PictureLiveness::health_changed(const RenderHealth& health) {
  if (health.devices_lost > health_.devices_lost) {
    awaits_new_device_ = true;
    lost_ns_ = updated_ns_;
  }
  if (has_device(health) && !has_device(health_)) device_back_ns_ = health.since_ns;
  health_ = health;
}

void PictureLiveness::shown(const PictureStamp& stamp, std::int64_t now_ns) {
  // A picture of the lost device may come late.
  if (has_device(health_) && stamp.finished_time_ns >= device_back_ns_) awaits_new_device_ = false;
  const VolumeStamp& volume = stamp.volume;
  if (any_picture_ && volume.last_capture_time_ns <= captured_ns_) {
    captured_ns_ = volume.last_capture_time_ns;  // an older one, of the cine
    return;
  }
  count(now_ns);
  any_picture_ = true;
  captured_ns_ = volume.last_capture_time_ns;
  volume_id_ = volume.volume_id;
  sweep_ns_ = std::max<std::int64_t>(0, volume.last_capture_time_ns - volume.first_capture_time_ns);
  frame_ns_ = volume.frames > 1 ? sweep_ns_ / (volume.frames - 1) : 0;
  progressed_ns_ = now_ns;
  for (Growth* growth : {&frames_, &volumes_, &dropped_, &refused_}) growth->before_progress = growth->count;
  progress_.push_back(now_ns);
  if (progress_.size() > kRatePictures) progress_.pop_front();
}

std::int64_t PictureLiveness::limit_ns() const {
  return std::max(kLeastLimitNs, kSweepsOfALivePicture * sweep_ns_);
}

void PictureLiveness::count(std::int64_t now_ns) {
  const AcquisitionCounters& frames = pipeline_.acquisition;
  frames_.see(frames.frames_received.value(), now_ns);
  dropped_.see(frames.volumes_incomplete.value() + frames.volumes_short.value(), now_ns);
  volumes_.see(pipeline_.ring.volumes_published.value(), now_ns);
  refused_.see(pipeline_.render.volumes_refused.value(), now_ns);
}

bool PictureLiveness::frames_silent(std::int64_t now_ns) const {
  return now_ns - frames_.grown_ns > std::max(kLeastLimitNs, kSweepsOfALivePicture * frame_ns_);
}

PictureLiveness::Cause PictureLiveness::cause(const Source& source, std::int64_t now_ns) const {
  if (source.state == Source::State::kFailed) return Cause::kSourceFailed;
  if (source.state == Source::State::kEnded) return Cause::kSourceEnded;
  if (source.probe_lost) return Cause::kProbeLost;
  if (health_.state == RenderHealth::State::kRemaking) return Cause::kGpuRemade;
  if (health_.state == RenderHealth::State::kHung) return Cause::kGpuHung;
  if (lacks_new_picture(source, now_ns)) return Cause::kGpuRemade;
  const bool still = now_ns - progressed_ns_ > limit_ns();
  const bool asks_no_progress = source.frozen || source.resting;
  if ((still || asks_no_progress) && driver_.silent_ns() > kLeastLimitNs) return Cause::kDriverSilent;
  if (source.is_replay) return still ? cause_of_replay(now_ns) : Cause::kNone;
  if (frames_silent(now_ns)) return Cause::kNoFrames;
  return still ? cause_of_stillness(now_ns) : Cause::kNone;
}

/// Frames and sweeps of a replay take as long as its speed says; only the renderer can be behind.
PictureLiveness::Cause PictureLiveness::cause_of_replay(std::int64_t now_ns) const {
  if (refused_.since(progressed_ns_) && now_ns - refused_.grown_ns <= limit_ns())
    return Cause::kVolumesRefused;
  constexpr std::uint64_t kUnseenVolumes = 2;
  const bool behind = volumes_.count - volumes_.before_progress > kUnseenVolumes;
  return behind ? Cause::kRendererBehind : Cause::kNone;
}

PictureLiveness::Cause PictureLiveness::cause_of_stillness(std::int64_t now_ns) const {
  // A volume that was published before the last picture may be the one that is refused now.
  if (refused_.since(progressed_ns_) && now_ns - refused_.grown_ns <= limit_ns())
    return Cause::kVolumesRefused;
  if (volumes_.since(progressed_ns_)) return Cause::kRendererBehind;
  return dropped_.since(progressed_ns_) ? Cause::kSweepsDropped : Cause::kNoSweep;
}

PictureLiveness::State PictureLiveness::state(const Source& source, Cause cause, std::int64_t now_ns) const {
  if (source.resting) return cause == Cause::kNone ? State::kResting : State::kNotLive;
  if (!any_picture_) return State::kWaiting;
  if (source.frozen) return State::kFrozen;
  if (cause != Cause::kNone) return State::kNotLive;
  if (source.is_replay || source.origin == FrameOrigin::kRecording) return State::kReplay;
  return now_ns - captured_ns_ > limit_ns() ? State::kDelayed : State::kLive;
}

double PictureLiveness::rate() const {
  if (progress_.size() < 2) return 0;
  const std::int64_t span_ns = progress_.back() - progress_.front();
  return span_ns > 0 ? static_cast<double>(progress_.size() - 1) / seconds(span_ns) : 0;
}

bool PictureLiveness::update(const Source& source, std::int64_t now_ns) {
  count(now_ns);
  // A pause that was asked for is no stillness, nor is the first moment after it.
  if (source.frozen || source.paused || (source.is_replay && source.state != Source::State::kRunning))
    progressed_ns_ = frames_.grown_ns = now_ns;
  if (source.resting) {
    progressed_ns_ = now_ns;
    any_picture_ = false;  // the next one is of a volume that is captured now
    has_rested_ = true;
    progress_.clear();
  }
  driver_.observe(pipeline_.render.turn_began_ns.value(), now_ns);
  count_loss(source, now_ns);
  const State before = report_.state;
  const Cause cause_before = report_.cause;
  const FrameOrigin origin_before = report_.origin;
  report_.origin = source.is_replay ? FrameOrigin::kRecording : source.origin;
  report_.cause = cause(source, now_ns);
  report_.state = state(source, report_.cause, now_ns);
  report_.scene_trouble = any_picture_ ? source.scene_trouble : "";
  if (report_.cause == Cause::kNone && !report_.scene_trouble.empty()) report_.cause = Cause::kChangeNotShown;
  report_.age_s = any_picture_ ? std::max(0.0, seconds(now_ns - captured_ns_)) : -1;
  const bool still = now_ns - progressed_ns_ > limit_ns();
  report_.pictures_per_second = still ? 0 : rate();
  report_.sentence = sentence(source, now_ns);
  if (!report_.scene_trouble.empty()) report_.sentence += " " + report_.scene_trouble;
  return report_.state != before || report_.cause != cause_before || report_.origin != origin_before;
}

void PictureLiveness::count_loss(const Source& source, std::int64_t now_ns) {
  const std::int64_t gap_ns =
      std::clamp<std::int64_t>(now_ns - std::exchange(updated_ns_, now_ns), 0, DriverWatch::kMostGapNs);
  // A device that refuses volumes works, and has no room.
  if (has_device(health_) && refused_.since(std::max(lost_ns_, device_back_ns_))) awaits_new_device_ = false;
  // A driver that compiles for the new device has a limit of its own.
  const std::int64_t more_ns = driver_.silent_ns() > 0 ? 0 : gap_ns;
  gpu_lost_ns_ = lacks_new_picture(source, now_ns) ? gpu_lost_ns_ + more_ns : 0;
}

/// The GPU was lost, and there is something to show on its new device.
bool PictureLiveness::lacks_new_picture(const Source& source, std::int64_t now_ns) const {
  const bool has_nothing = frames_silent(now_ns) && !volumes_.since(lost_ns_);
  return awaits_new_device_ && !source.resting && !has_nothing;
}

bool PictureLiveness::renders() const {
  return any_picture_ && has_device(health_) && report_.cause != Cause::kDriverSilent;
}

std::string PictureLiveness::live_sentence() const {
  switch (report_.origin) {
    case FrameOrigin::kUnknown:
      return "The picture is live as far as the sender of the frames says.";
    case FrameOrigin::kSimulated:
      return "The picture is live, of a simulated probe.";
    default:
      return "The picture is live.";
  }
}

/// Pictures come, and each is old: who is late.
std::string PictureLiveness::delay_sentence(std::int64_t now_ns) const {
  const double frame_age_s = pipeline_.acquisition.frame_age_s.value();
  if (frame_age_s > seconds(limit_ns()) / 2)
    return fmt::format("The source's frames are {:.1f} s old when they come.", frame_age_s);
  if (volumes_.count > volume_id_)
    return fmt::format("The renderer is slower than the probe: {:.1f} pictures a second.",
                       report_.pictures_per_second);
  const double silent_s = seconds(now_ns - frames_.grown_ns);
  if (silent_s > seconds(limit_ns()) / 2)
    return fmt::format("The source has sent no frame for {:.1f} s.", silent_s);
  if (dropped_.count > dropped_.before_progress) return "The last sweep is missing too many frames.";
  return "The next sweep is not complete yet.";
}

std::string PictureLiveness::replay_sentence(const Source& source) const {
  if (!source.is_replay) return "The sender of the frames plays a recording.";
  return source.paused ? "The replay of a recording is paused." : "A recording is played.";
}

std::string PictureLiveness::sentence(const Source& source, std::int64_t now_ns) const {
  switch (report_.state) {
    case State::kLive:
      return live_sentence();
    case State::kFrozen:
      return frozen_sentence(source, now_ns);
    case State::kResting:
      return "There are no viewers, so no picture is rendered.";
    case State::kReplay:
      return replay_sentence(source);
    case State::kDelayed:
      return delay_sentence(now_ns);
    case State::kWaiting:
      if (report_.cause == Cause::kNone)
        return has_rested_ ? "The picture is being rendered." : "The first volume is not complete yet.";
      break;
    case State::kNotLive:
      break;
  }
  return reason(source, now_ns);
}

/// A frozen picture stays frozen whatever becomes of the source, but that is said.
std::string PictureLiveness::frozen_sentence(const Source& source, std::int64_t now_ns) const {
  const std::string cause = reason(source, now_ns);
  const std::string frozen =
      source.is_replay ? "The replay of a recording is frozen." : "The picture is frozen.";
  return frozen + (cause.empty() ? "" : " " + cause);
}

std::string PictureLiveness::reason(const Source& source, std::int64_t now_ns) const {
  const auto ago = [now_ns](std::int64_t time_ns) {
    return fmt::format("{:.0f} s", seconds(now_ns - time_ns));
  };
  switch (report_.cause) {
    case Cause::kNone:
    case Cause::kChangeNotShown:  // update() adds its sentence to that of the state
      return "";
    case Cause::kSourceFailed:
      return fmt::format("{}: {}.", source.is_replay ? "The replay has stopped" : "The source has failed",
                         source.failure);
    case Cause::kSourceEnded:
      return "The recording has ended.";
    case Cause::kProbeLost:
      return "The probe is lost.";
    case Cause::kGpuRemade:
      if (has_device(health_))
        return "The GPU was lost and started again: no picture has been rendered since.";
      return fmt::format("The GPU was lost and is started again: {}.", health_.cause.view());
    case Cause::kGpuHung:
      return fmt::format("The GPU does not answer: {}.", health_.cause.view());
    case Cause::kDriverSilent:
      return fmt::format("The GPU's driver has not answered for {:.0f} s.", seconds(driver_.silent_ns()));
    case Cause::kNoFrames:
      return fmt::format("The source has sent no frame for {}.{}{}", ago(frames_.grown_ns),
                         source.trouble.empty() ? "" : " ", source.trouble);
    case Cause::kVolumesRefused:
      return fmt::format(
          "The GPU refuses every volume{}.",
          health_.volume_refusal.empty() ? "" : fmt::format(": {}", health_.volume_refusal.view()));
    case Cause::kRendererBehind:
      return fmt::format("The renderer has finished no picture for {}.", ago(progressed_ns_));
    case Cause::kSweepsDropped:
      return fmt::format("Every sweep is missing too many frames: {} dropped in {}.",
                         dropped_.count - dropped_.before_progress, ago(progressed_ns_));
    case Cause::kNoSweep:
      return fmt::format("Frames come, but no sweep has ended for {}.", ago(progressed_ns_));
  }
  return "";
}

}  // namespace fanlight
