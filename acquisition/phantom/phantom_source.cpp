// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/phantom_source.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/phantom/phantom_options.hpp"
#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

using Config = PhantomSource::Config;

constexpr double kFieldMm = 160;

// Of the convex array.
constexpr double kSectorHalfAngleDeg = 35;

constexpr std::int16_t kNoEcho = -1000;  // below any grey level

constexpr double kSlopeReachMm = 0.75;  // the slope is measured over this distance to either side
// Frames that the probe buffers while the caller takes none.
constexpr double kBufferedFrames = 8;
constexpr double kNsPerS = 1e9;
// Where stamps do not name the volume, the first frames of a sweep count as the last ones of the sweep
// before, until the reversal is detected.
constexpr std::uint32_t kTurnSeenLate = 8;
constexpr std::uint64_t kOfLosses =
    0x6c6f'7374;  // separates these random numbers from others of the same seed

PhantomMotor::Config motor_of(const Config& config) {
  return {.frames_per_volume = config.frames_per_volume,
          .sweep_rad = radians(config.sweep_deg),
          .lag_rad = radians(config.lag_deg),
          .jitter_rad = radians(config.jitter_deg),
          .turning_frames = config.turning_frames,
          .seed = config.seed};
}

std::optional<BodyScene::Kind> bodies_of(PhantomSource::Scene scene) {
  switch (scene) {
    case PhantomSource::Scene::kRelief:
      return std::nullopt;
    case PhantomSource::Scene::kFace:
      return BodyScene::Kind::kFace;
    case PhantomSource::Scene::kWomb:
      return BodyScene::Kind::kWomb;
    case PhantomSource::Scene::kSphere:
      return BodyScene::Kind::kSphere;
    case PhantomSource::Scene::kPlane:
      return BodyScene::Kind::kPlane;
    case PhantomSource::Scene::kCyst:
      return BodyScene::Kind::kCyst;
  }
  return std::nullopt;
}

FanGeometry geometry_of(const Config& config) {
  FanGeometry geometry{.kind = config.scan,
                       .columns = config.columns,
                       .rows = config.rows,
                       .pixel_height_mm = kFieldMm / config.rows,
                       .face_column = (config.columns - 1) / 2.0,
                       .face_row = 0,
                       .motor_radius_mm = config.motor_radius_mm};
  if (config.scan == FrameKind::kConvexLines) {
    geometry.line_pitch_deg = 2 * kSectorHalfAngleDeg / (config.columns - 1);
  } else {
    geometry.pixel_width_mm = kFieldMm / config.columns;
  }
  if (config.scan != FrameKind::kLinearLines) geometry.probe_radius_mm = config.probe_radius_mm;
  if (config.scan == FrameKind::kCartesian) {
    geometry.sector = {.half_angle_deg = kSectorHalfAngleDeg, .reach_mm = config.probe_radius_mm + kFieldMm};
  }
  return geometry;
}

/// The face and the hand at it.
std::optional<SourceDescription::Subject> subject_of(PhantomSource::Scene scene) {
  if (scene != PhantomSource::Scene::kFace) return std::nullopt;
  return SourceDescription::Subject{.middle = {4, 95, -6}, .height_mm = 135};
}

}  // namespace

Result<std::unique_ptr<PhantomSource>> PhantomSource::create(const Config& config) {
  if (const auto checked = check_phantom(config); !checked) return checked.error();
  return std::unique_ptr<PhantomSource>(new PhantomSource(config));
}

PhantomSource::PhantomSource(const Config& config)
    : config_(config),
      motor_(motor_of(config)),
      description_{
          .name = "phantom:",
          .geometry = geometry_of(config),
          .counts_volumes = config.index == Index::kOn,
          .frames_per_volume = motor_.most_frames() + (config.index == Index::kOn ? 0 : kTurnSeenLate),
          .volumes = config.volumes,
          .first_angle_rad = -motor_.furthest_rad(),
          .last_angle_rad = motor_.furthest_rad(),
          .origin = FrameOrigin::kSimulated,
          .simulated = true,
          .subject = subject_of(config.scene)},
      scene_(config.motion),
      speckle_(speckle_of_frames()),
      echo_(config.scale, kFieldMm),
      surface_depths_mm_(config.columns),
      depths_below_mm_(config.columns),
      depths_above_mm_(config.columns) {
  const FanGeometry& geometry = description_.geometry;
  for (std::uint32_t column = 0; column < geometry.columns; ++column) {
    const double angle_rad = geometry.line_angle_rad(column);
    across_.push_back(
        static_cast<float>(geometry.polar() ? std::sin(angle_rad) : column - geometry.face_column));
    ahead_.push_back(geometry.polar() ? static_cast<float>(std::cos(angle_rad)) : 0.0F);
  }
  for (std::uint32_t row = 0; row < geometry.rows; ++row) rows_.push_back(row_of(row));
  if (const auto bodies = bodies_of(config.scene)) {
    bodies_ = std::make_unique<BodyFrames>(
        BodyFrames::Config{.kind = *bodies,
                           .moving = config.motion == PhantomScene::Motion::kMoving,
                           .seed = config.seed,
                           .has_near_wall = config.near_wall == NearWall::kOn,
                           .has_speckle = config.speckle == Speckle::kOn,
                           .has_clutter = config.clutter == Clutter::kOn,
                           .frame_step_rad = motor_.step_rad(),
                           .beam_mm = config.beam_mm,
                           .scale = config.scale},
        geometry);
  } else {
    none_.assign(geometry.columns, kNoEcho);
    // Without speckle, frames beside the relief would be exact copies, which the assembler reports as frozen.
    const bool has_speckle = config.speckle == Speckle::kOn;
    if (config.clutter == Clutter::kOn && has_speckle) reverberation_ = reverberation_of_pixels();
  }
}

/// Of the rows that come near enough to the probe's face.
std::vector<std::int16_t> PhantomSource::reverberation_of_pixels() const {
  const FanGeometry& geometry = description_.geometry;
  std::vector<std::int16_t> greys;
  for (std::uint32_t row = 0; row * geometry.pixel_height_mm < BeamEcho::kReverberationMm; ++row) {
    for (std::uint32_t column = 0; column < geometry.columns; ++column) {
      const double along_mm = row * geometry.pixel_height_mm;
      const double across_mm =
          geometry.kind == FrameKind::kCartesian ? across_[column] * geometry.pixel_width_mm : 0;
      const double from_face_mm =
          std::hypot(across_mm, along_mm + geometry.probe_radius_mm) - geometry.probe_radius_mm;
      const double power = BeamEcho::reverberation(static_cast<float>(from_face_mm));
      const double grey = power > 0 ? config_.scale.grey(std::sqrt(power)) : kNoEcho;
      greys.push_back(static_cast<std::int16_t>(std::clamp(grey, double{kNoEcho}, 1000.0)));
    }
  }
  return greys;
}

FrameSpeckle PhantomSource::speckle_of_frames() const {
  const FanGeometry& geometry = description_.geometry;
  if (config_.speckle == Speckle::kOff || bodies_of(config_.scene)) return FrameSpeckle(geometry.columns);
  const double deviation_mm = config_.beam_mm * BeamEcho::kDeviationOfBeam;
  std::vector<float> deviations;
  for (std::uint32_t row = 0; row < geometry.rows; ++row) {
    const double frame_mm = motor_.step_rad() * (row * geometry.pixel_height_mm + geometry.motor_radius_mm);
    deviations.push_back(static_cast<float>(deviation_mm / frame_mm));
  }
  return {config_.seed, geometry.columns, std::move(deviations)};
}

/// On the fan, counted from the first angle of a sweep that turned on time.
FrameSpeckle::Place PhantomSource::place() const {
  return {.sweep = sweep_, .frame = (true_angle_rad_ + radians(config_.sweep_deg) / 2) / motor_.step_rad()};
}

PhantomSource::Row PhantomSource::row_of(std::uint32_t row) const {
  const FanGeometry& geometry = description_.geometry;
  const double depth_mm = row * geometry.pixel_height_mm;
  const double from_apex_mm = depth_mm + geometry.probe_radius_mm;
  if (geometry.polar()) {
    return {.scale_mm = from_apex_mm, .depth_mm = -geometry.probe_radius_mm, .end = geometry.columns};
  }
  Row straight{.scale_mm = geometry.pixel_width_mm, .depth_mm = depth_mm, .end = geometry.columns};
  const FanGeometry::Sector& sector = geometry.sector;
  if (sector.half_angle_deg == 0) return straight;
  const double half_width_mm =
      std::min({from_apex_mm * std::tan(radians(sector.half_angle_deg)), -geometry.left_mm(),
                std::sqrt(sector.reach_mm * sector.reach_mm - from_apex_mm * from_apex_mm)});
  const double half_columns = half_width_mm / geometry.pixel_width_mm;
  straight.first = static_cast<std::uint32_t>(std::ceil(geometry.face_column - half_columns));
  straight.end = geometry.columns - straight.first;
  return straight;
}

double PhantomSource::scene_time_s(const FrameStamp& frame) const {
  return static_cast<double>(frame.capture_time_ns - start_ns_) / kNsPerS;
}

std::int64_t PhantomSource::capture_time_ns(std::uint64_t sequence) const {
  return start_ns_ + std::llround(static_cast<double>(sequence) * (kNsPerS / config_.frame_rate_hz));
}

FrameStamp PhantomSource::stamp(std::uint64_t sequence, const PhantomMotor::Position& position) const {
  FrameStamp stamp{.sequence = sequence,
                   .angle_rad = position.measured_angle_rad,
                   .capture_time_ns = capture_time_ns(sequence)};
  if (config_.index == Index::kOff) return stamp;
  stamp.volume_index = position.sweep;
  stamp.frame_index = position.frame_in_sweep;
  stamp.frames_in_sweep = config_.turning_frames > 0 ? 0 : config_.frames_per_volume;
  stamp.direction = position.direction;
  return stamp;
}

bool PhantomSource::lost(std::uint64_t sequence) const {
  const std::uint64_t bits = mixed_bits(config_.seed + mixed_bits(sequence + kOfLosses));
  return std::ldexp(static_cast<double>(bits), -64) * 100 < config_.lost_percent;
}

Result<std::optional<FrameStamp>> PhantomSource::next_frame(std::stop_token stop) {
  thread_owner_.check();
  const bool paced = config_.pace != Pace::kUnpaced;
  if (paced && next_sequence_ == 0) start_ns_ = now_ns();
  while (lost(next_sequence_)) ++next_sequence_;
  if (config_.pace == Pace::kRealTime) {
    const double late_ns = static_cast<double>(now_ns() - capture_time_ns(next_sequence_));
    const double late_frames = std::floor(late_ns * config_.frame_rate_hz / kNsPerS);
    if (late_frames > kBufferedFrames)
      next_sequence_ += static_cast<std::uint64_t>(late_frames - kBufferedFrames);
  }
  if (paced && !pacer_.wait_until(capture_time_ns(next_sequence_), stop)) return std::optional<FrameStamp>{};
  const PhantomMotor::Position position = motor_.at(next_sequence_);
  const bool ended = config_.volumes > 0 && position.sweep >= config_.volumes;
  if (ended || stop.stop_requested()) return std::optional<FrameStamp>{};
  true_angle_rad_ = position.true_angle_rad;
  sweep_ = position.sweep;
  current_ = stamp(next_sequence_++, position);
  return std::optional(current_);
}

FrameFault PhantomSource::read_pixels(std::span<std::uint8_t> pixels, std::stop_token /*stop*/) {
  thread_owner_.check();
  if (bodies_) {
    bodies_->draw({.time_s = scene_time_s(current_), .angle_rad = true_angle_rad_, .place = place()}, pixels);
    return FrameFault::kNone;
  }
  const Exposure exposure{.pose = scene_.pose_at(scene_time_s(current_)),
                          .sine = std::sin(true_angle_rad_),
                          .cosine = std::cos(true_angle_rad_)};
  speckle_.set_place(place());
  const std::uint32_t columns = description_.geometry.columns;
  for (std::uint32_t row = 0; row < rows_.size(); ++row) {
    draw_row(row, exposure, pixels.subspan(std::size_t{row} * columns, columns));
  }
  return FrameFault::kNone;
}

void PhantomSource::find_surface(const Row& row, const Point& base, const Exposure& exposure) {
  const std::uint32_t count = row.end - row.first;
  // Upper bound: ahead is at most 1 for any pixel.
  const double deepest_mm = base.y_mm + row.scale_mm * exposure.cosine;
  if (deepest_mm < scene_.nearest_depth_mm() - EchoModel::kBeforeMm) {
    for (auto* const depths_mm : {&surface_depths_mm_, &depths_below_mm_, &depths_above_mm_}) {
      std::fill_n(depths_mm->begin() + row.first, count, PhantomScene::kNoSurfaceMm);
    }
    return;
  }
  const auto find = [&](double beside_mm, std::vector<float>& depths_mm) {
    scene_.surface_row_mm(exposure.pose,
                          {.across = std::span(across_).subspan(row.first, count),
                           .ahead = std::span(ahead_).subspan(row.first, count),
                           .x_mm = row.scale_mm,
                           .z_mm = base.z_mm + beside_mm,
                           .ahead_z_mm = row.scale_mm * exposure.sine},
                          std::span(depths_mm).subspan(row.first, count));
  };
  find(0, surface_depths_mm_);
  find(-kSlopeReachMm, depths_below_mm_);
  find(kSlopeReachMm, depths_above_mm_);
}

void PhantomSource::draw_row(std::uint32_t row_index, const Exposure& exposure,
                             std::span<std::uint8_t> pixels) {
  const Row& row = rows_[row_index];
  std::fill_n(pixels.begin(), row.first, std::uint8_t{0});
  std::fill(pixels.begin() + row.end, pixels.end(), std::uint8_t{0});
  const Point base = description_.geometry.point(0, {.angle_rad = true_angle_rad_, .depth_mm = row.depth_mm});
  find_surface(row, base, exposure);

  // A step e out of the plane of the frame moves by (-sin, cos) in y and z, that is e (sin + cos dS/dz) in
  // depth relative to the surface.
  const double blurs_per_slope = config_.beam_mm * BeamEcho::kDeviationOfBeam / EchoModel::kBlurStepMm;
  const auto level = static_cast<float>(blurs_per_slope * exposure.sine);
  const auto per_mm = static_cast<float>(blurs_per_slope * exposure.cosine / (2 * kSlopeReachMm));
  const std::span<const std::uint8_t> factors = speckle_.row(row_index);
  const std::size_t first = std::size_t{row_index} * config_.columns;
  const std::span<const std::int16_t> reverberation =
      first < reverberation_.size() ? std::span(reverberation_).subspan(first, config_.columns)
                                    : std::span(none_);
  constexpr auto kPerMm = static_cast<float>(1 / EchoModel::kStepMm);
  const auto offset = static_cast<float>((base.y_mm + EchoModel::kBeforeMm) / EchoModel::kStepMm);
  const auto per_ahead = static_cast<float>(row.scale_mm * exposure.cosine / EchoModel::kStepMm);
  const std::uint32_t entries = echo_.entries();
  const auto last_entry = static_cast<float>(entries - 1);
  // A local copy: the compiler must assume that a written pixel aliases the members.
  const std::span<const float> ahead = ahead_;
  const std::span<const float> surface_mm = surface_depths_mm_;
  const std::span<const float> below_mm = depths_below_mm_;
  const std::span<const float> above_mm = depths_above_mm_;
  const std::int16_t* const greys = echo_.greys();
  const auto draw = [&](auto with_speckle) {
    for (std::uint32_t column = row.first, end = row.end; column < end; ++column) {
      const float depth = offset + per_ahead * ahead[column];
      const float entry = std::clamp(depth - surface_mm[column] * kPerMm, 0.0F, last_entry);
      const float slant = std::abs(level + per_mm * (above_mm[column] - below_mm[column]));
      const auto blur = static_cast<std::uint32_t>(std::min(slant + 0.5F, EchoModel::kBlurs - 0.5F));
      // The louder of two echoes: at most 3 dB less than their sum.
      const std::int32_t mean = std::max<std::int32_t>(
          reverberation[column], greys[blur * entries + static_cast<std::uint32_t>(entry)]);
      const std::uint32_t factor = factors[column];
      pixels[column] = static_cast<std::uint8_t>(std::clamp(with_speckle(mean, factor), 0, 255));
    }
  };
  if (config_.scale.kind == EchoScale::Kind::kLinear) {
    draw([](std::int32_t mean, std::uint32_t factor) {
      constexpr std::int32_t kOne = FrameSpeckle::kOne;
      return (mean * static_cast<std::int32_t>(factor) + kOne / 2) / kOne;
    });
  } else {
    const std::int16_t* const added = echo_.speckle_greys().data();
    draw([added](std::int32_t mean, std::uint32_t factor) { return mean + added[factor]; });
  }
}

}  // namespace fanlight
