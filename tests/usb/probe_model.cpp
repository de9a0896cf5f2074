// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/probe_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace fanlight::test {

namespace {

constexpr double kNsPerS = 1e9;
constexpr double kFullDepthMm = 160;
constexpr double kLeastDepthMm = 20;
constexpr double kLeastSweepDeg = 1;
constexpr double kMostSweepDeg = 170;
constexpr double kMicro = 1e6;
constexpr double kMicrometresInMm = 1e3;
constexpr double kRoomS = 0.05;
constexpr std::uint32_t kLeastRoomFrames = 2;
constexpr std::uint64_t kClockStartNs = 1'000'000'000;

template <typename T>
Result<void> check(std::string_view name, T value, T least, T most) {
  if (value >= least && value <= most) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("the emulated probe's {} is {}, expected {} to {}", name, value, least, most)};
}

template <std::size_t kBytes>
std::vector<std::uint8_t> as_answer(const std::array<std::uint8_t, kBytes>& block) {
  return {block.begin(), block.end()};
}

ProbePictures::Config pictures_config(const ProbeModel::Config& config, const probe::Settings& settings) {
  return {.frame_rate_hz = config.frame_rate_hz,
          .frames_per_volume = settings.frames_a_volume,
          .columns = config.columns,
          .rows = config.rows,
          .sweep_deg = settings.sweep_deg,
          .seed = config.seed,
          .prepared = config.prepared};
}

probe::Capabilities capabilities_of(const ProbeModel::Config& config) {
  return {.counts_volumes = config.counts_volumes,
          .least_sweep_deg = kLeastSweepDeg,
          .most_sweep_deg = kMostSweepDeg,
          .least_frames = 2,
          .most_frames = 1024,
          .least_depth_mm = kLeastDepthMm,
          .most_depth_mm = kFullDepthMm,
          .most_columns = config.columns,
          .most_rows = config.rows};
}

}  // namespace

Result<std::unique_ptr<ProbeModel>> ProbeModel::create(const Config& config) {
  for (const auto& checked : {check("frame rate", config.frame_rate_hz, 0.1, 100'000.0),
                              check("depth", config.depth_mm, kLeastDepthMm, kFullDepthMm),
                              check("lag", config.lag_deg, -4.0, 4.0)}) {
    if (!checked) return checked.error();
  }
  // The phantom checks the rest.
  auto pictures = ProbePictures::create(
      pictures_config(config, {.sweep_deg = config.sweep_deg, .frames_a_volume = config.frames_per_volume}));
  if (!pictures) return pictures.error();
  std::unique_ptr<ProbeModel> model(new ProbeModel(config, std::move(*pictures)));
  model->pictures_->prepare(model->active_rows_);
  return model;
}

ProbeModel::ProbeModel(const Config& config, std::shared_ptr<ProbePictures> pictures)
    : config_(config),
      room_frames_(config.room_frames),
      pictures_(std::move(pictures)),
      active_rows_(rows_of(config.depth_mm)),
      noise_(config.seed) {
  if (room_frames_ == 0) {
    room_frames_ =
        std::max(kLeastRoomFrames, static_cast<std::uint32_t>(std::ceil(kRoomS * config.frame_rate_hz)));
  }
  set_ = {.sweep_deg = config.sweep_deg, .frames_a_volume = config.frames_per_volume};
  set_.depth_mm = active_rows_ * kFullDepthMm / config.rows;
  active_ = set_;
}

// Control pipe.

std::optional<std::vector<std::uint8_t>> ProbeModel::control_in(std::uint8_t request) const {
  switch (static_cast<probe::Request>(request)) {
    case probe::Request::kIdentity:
      return as_answer(encode(
          probe::Identity{.model = "Fanlight emulated probe", .serial = config_.serial, .firmware = "1.0"}));
    case probe::Request::kCapabilities:
      return as_answer(encode(capabilities_of(config_)));
    case probe::Request::kGeometry:
      return as_answer(encode(geometry()));
    case probe::Request::kSettings:
      return as_answer(encode(set_));
    default:
      return std::nullopt;
  }
}

bool ProbeModel::control_out(std::uint8_t request, std::span<const std::uint8_t> data, std::int64_t now_ns) {
  const auto asked = static_cast<probe::Request>(request);
  if (asked == probe::Request::kStart || asked == probe::Request::kStop) {
    if (!data.empty()) return false;
    advance(now_ns);
    stop();
    if (asked == probe::Request::kStart) start(now_ns);
    return true;
  }
  if (data.size() != sizeof(std::uint32_t)) return false;
  // Frames that are due were captured before the setting arrived.
  advance(now_ns);
  if (!set(asked, data[0] | data[1] << 8 | data[2] << 16 | std::uint32_t{data[3]} << 24)) return false;
  if (!streaming_) apply_settings();
  return true;
}

bool ProbeModel::set(probe::Request setting, std::uint32_t value) {
  const probe::Capabilities able = capabilities_of(config_);
  const auto within = [](double asked, double least, double most) { return asked >= least && asked <= most; };
  switch (setting) {
    case probe::Request::kSetSweep:
      if (!within(value / kMicro, able.least_sweep_deg, able.most_sweep_deg)) return false;
      set_.sweep_deg = value / kMicro;
      return true;
    case probe::Request::kSetFrames:
      if (!within(value, able.least_frames, able.most_frames)) return false;
      set_.frames_a_volume = value;
      return true;
    case probe::Request::kSetDepth:
      if (!within(value / kMicrometresInMm, able.least_depth_mm, able.most_depth_mm)) return false;
      set_.depth_mm = rows_of(value / kMicrometresInMm) * kFullDepthMm / config_.rows;
      return true;
    default:
      return false;
  }
}

probe::Geometry ProbeModel::geometry() const {
  probe::Geometry geometry{.revision = geometry_revision_, .fan = pictures_->geometry()};
  geometry.fan.rows = active_rows_;
  return geometry;
}

std::uint32_t ProbeModel::rows_of(double depth_mm) const {
  const auto rows = static_cast<std::uint32_t>(std::lround(depth_mm * config_.rows / kFullDepthMm));
  return std::clamp(rows, 2U, config_.rows);
}

void ProbeModel::change_depth(std::uint32_t rows) {
  if (rows == active_rows_) return;
  active_rows_ = rows;
  active_.depth_mm = rows * kFullDepthMm / config_.rows;
  ++geometry_revision_;
}

void ProbeModel::apply_settings() {
  change_depth(rows_of(set_.depth_mm));
  if (active_.sweep_deg == set_.sweep_deg && active_.frames_a_volume == set_.frames_a_volume) return;
  auto pictures = ProbePictures::create(pictures_config(config_, set_));
  if (!pictures) return;  // not possible: the ranges are the phantom's
  // The scene continues at about the same time, and the motor from its present end.
  const auto direction = pictures_->place(picture_).direction;
  std::uint64_t sweep = picture_ / set_.frames_a_volume;
  if ((sweep % 2 == 0) != (direction == SweepDirection::kForward)) ++sweep;
  first_volume_ += pictures_->place(picture_).sweep - first_sweep_;
  first_sweep_ = sweep;
  picture_ = sweep * set_.frames_a_volume;
  pictures_ = std::move(*pictures);
  active_.sweep_deg = set_.sweep_deg;
  active_.frames_a_volume = set_.frames_a_volume;
}

// Streaming.

void ProbeModel::start(std::int64_t now_ns) {
  ++counters_.starts;
  if (!powered_ns_) powered_ns_ = now_ns;
  streaming_ = true;
  random_ = false;
  started_ns_ = now_ns;
  taken_since_start_ = 0;
  apply_settings();
  begin_first_sweep();
}

/// The next frame is number 0, the first one of a forward sweep.
void ProbeModel::begin_first_sweep() {
  sequence_ = 0;
  first_volume_ = 0;
  const std::uint64_t sweeps = 2 * std::uint64_t{active_.frames_a_volume};
  picture_ = (picture_ + sweeps - 1) / sweeps * sweeps;
  first_sweep_ = pictures_->place(picture_).sweep;
}

void ProbeModel::stop() {
  streaming_ = false;
  forget_frames();
}

void ProbeModel::forget_frames() {
  tear();
  counters_.frames_dropped += queue_.size() + (held_ ? 1 : 0);
  queue_.clear();
  held_.reset();
}

void ProbeModel::unplugged() {
  stop();
  powered_ns_.reset();
  pending_ = {};
  random_ = false;
  silent_until_ns_ = 0;
  set_ = {.sweep_deg = config_.sweep_deg, .frames_a_volume = config_.frames_per_volume};
  active_rows_ = rows_of(config_.depth_mm);
  set_.depth_mm = active_.depth_mm = active_rows_ * kFullDepthMm / config_.rows;
  geometry_revision_ = 1;
}

std::int64_t ProbeModel::due_ns(std::uint64_t frame) const {
  return started_ns_ + std::llround(static_cast<double>(frame) * (kNsPerS / config_.frame_rate_hz));
}

void ProbeModel::advance(std::int64_t now_ns) {
  if (!streaming_) return;
  while (due_ns(taken_since_start_) <= now_ns) {
    take(due_ns(taken_since_start_++));
    if (queue_.size() <= room_frames_) continue;
    queue_.pop_front();
    ++counters_.frames_dropped;
  }
}

void ProbeModel::take(std::int64_t due_ns) {
  if (pictures_->place(picture_).index == 0) apply_settings();
  const ProbePictures::Place place = pictures_->place(picture_);
  const double behind_deg =
      place.direction == SweepDirection::kForward ? config_.lag_deg / 2 : -config_.lag_deg / 2;
  Taken frame{.header = {.sequence = sequence_++,
                         .device_time_ns = kClockStartNs + static_cast<std::uint64_t>(due_ns - *powered_ns_),
                         .angle_deg = std::clamp(place.angle_deg - behind_deg, -90.0, 90.0),
                         .geometry_revision = geometry_revision_,
                         .payload_bytes = config_.columns * active_rows_},
              .pictures = pictures_,
              .picture = picture_++,
              .rows = active_rows_};
  if (config_.counts_volumes) {
    frame.header.volume_index = static_cast<std::uint32_t>(first_volume_ + place.sweep - first_sweep_);
    frame.header.frame_index = static_cast<std::uint16_t>(place.index);
    frame.header.frames_in_sweep = static_cast<std::uint16_t>(active_.frames_a_volume);
    frame.header.direction = place.direction;
  }
  queue_.push_back(std::move(frame));
  ++counters_.frames_taken;
}

std::optional<std::int64_t> ProbeModel::ready_at_ns() const {
  if (!streaming_ && between_frames()) return std::nullopt;
  const bool at_once = !between_frames() || !queue_.empty() || (held_ && successor_sent_);
  return std::max(silent_until_ns_, at_once ? started_ns_ : due_ns(taken_since_start_));
}

std::uint64_t ProbeModel::waiting() const {
  const bool sending = under_way_ && (under_way_->fate == Fate::kSent || under_way_->fate == Fate::kTorn);
  return queue_.size() + (held_ ? 1 : 0) + (sending ? 1 : 0);
}

}  // namespace fanlight::test
