// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/body_frames.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace fanlight {

namespace {

constexpr std::uint32_t kFewestLines = 16;
// Between two lines in memory: one sample of all lines is read at a time, and with a distance of a power of
// two they would share a few lines of the cache.
constexpr std::uint32_t kPadding = 16;

// Side lobes: 30 dB below the mean of what lies within this angle to either side, at the same range. A
// scanner's apodisation leaves less, and tissue before the target brings them up again.
constexpr double kLobeAngleRad = 0.2;
constexpr double kLobeMm = 20;  // of parallel lines
constexpr float kLobePower = 1e-3F;

/// Grey levels of all positive floats: the upper 16 bits give them to a hundredth.
std::vector<std::int16_t> greys_of_powers(const EchoScale& scale) {
  std::vector<std::int16_t> greys(std::size_t{1} << 15);
  for (std::uint32_t bits = 0; bits < greys.size(); ++bits) {
    const auto power = std::bit_cast<float>(bits << 16 | 1U << 15);
    const double grey = std::isfinite(power) ? scale.grey(std::sqrt(static_cast<double>(power))) : 1000;
    greys[bits] = static_cast<std::int16_t>(std::lround(std::clamp(grey, -1000.0, 1000.0)));
  }
  return greys;
}

}  // namespace

BodyFrames::BodyFrames(const Config& config, const FanGeometry& geometry)
    : geometry_(geometry),
      scale_(config.scale),
      scene_(config.kind, config.moving, config.seed, config.has_near_wall),
      beam_(config.beam_mm),
      samples_in_line_(geometry.rows),
      line_stride_(geometry.rows + kPadding),
      greys_(greys_of_powers(config.scale)),
      speckle_greys_(config.scale.speckle_greys()) {
  const auto step_mm = static_cast<float>(geometry.pixel_height_mm);
  const auto face_mm = static_cast<float>(geometry.probe_radius_mm);
  samples_ = {.first_mm = face_mm, .step_mm = step_mm, .face_mm = face_mm};
  if (geometry.kind == FrameKind::kLinearLines) {
    for (std::uint32_t column = 0; column < geometry.columns; ++column)
      lines_.push_back({.x_mm = (column - geometry.face_column) * geometry.pixel_width_mm});
  } else {
    const bool converts = geometry.kind == FrameKind::kCartesian;
    const std::uint32_t count =
        converts ? std::max(geometry.columns * 3 / 8, kFewestLines) : geometry.columns;
    const double half_angle_rad =
        converts ? radians(geometry.sector.half_angle_deg) : -geometry.line_angle_rad(0);
    for (std::uint32_t line = 0; line < count; ++line) {
      const double angle_rad = std::lerp(-half_angle_rad, half_angle_rad, line / (count - 1.0));
      lines_.push_back({.depth_mm = -geometry.probe_radius_mm,
                        .sine = std::sin(angle_rad),
                        .cosine = std::cos(angle_rad)});
    }
    if (converts) {
      converter_.emplace(ScanConverter::Lines{.lines = count,
                                              .samples = samples_in_line_,
                                              .half_angle_rad = half_angle_rad,
                                              .step_mm = geometry.pixel_height_mm},
                         geometry);
      scanned_.resize(std::size_t{count} * samples_in_line_);
    }
  }
  power_.resize(lines_.size() * line_stride_);
  sums_.resize(lines_.size() + 1);
  blurred_.resize(lines_.size());
  const bool parallel = geometry.kind == FrameKind::kLinearLines;
  const double pitch =
      parallel ? geometry.pixel_width_mm : std::asin(lines_[1].sine) - std::asin(lines_[0].sine);
  if (config.has_clutter)
    lobe_lines_ = static_cast<std::uint32_t>((parallel ? kLobeMm : kLobeAngleRad) / pitch);
  for (std::uint32_t sample = 0; sample < samples_in_line_; ++sample) {
    const auto from_face_mm = static_cast<float>(sample * geometry.pixel_height_mm);
    reverberation_.push_back(config.has_clutter ? BeamEcho::reverberation(from_face_mm) : 0.0F);
  }
  const auto lines = static_cast<std::uint32_t>(lines_.size());
  if (!config.has_speckle) {
    speckle_.emplace(lines);
    return;
  }
  std::vector<float> deviations;
  for (std::uint32_t sample = 0; sample < samples_in_line_; ++sample) {
    const double depth_mm = sample * geometry.pixel_height_mm;
    const double frame_mm = config.frame_step_rad * (depth_mm + geometry.motor_radius_mm);
    deviations.push_back(beam_.deviation_mm(static_cast<float>(depth_mm)) / static_cast<float>(frame_mm));
  }
  speckle_.emplace(config.seed, lines, std::move(deviations));
}

BodyScene::Line BodyFrames::in_transducer_frame(const ScanLine& line, double angle_rad) const {
  const Point from = geometry_.point(line.x_mm, {.angle_rad = angle_rad, .depth_mm = line.depth_mm});
  const double sine = std::sin(angle_rad);
  const double cosine = std::cos(angle_rad);
  return {.from_mm = {from.x_mm, from.y_mm, from.z_mm},
          .along = {line.sine, line.cosine * cosine, line.cosine * sine},
          .across = {0, -sine, cosine}};
}

void BodyFrames::draw(const Exposure& exposure, std::span<std::uint8_t> pixels) {
  const BodyScene::Poses poses = scene_.poses_at(exposure.time_s);
  for (std::size_t line = 0; line < lines_.size(); ++line) {
    beam_.draw(scene_, scene_.in_bodies(poses, in_transducer_frame(lines_[line], exposure.angle_rad)),
               samples_, std::span(power_).subspan(line * line_stride_, samples_in_line_));
  }
  const std::span<std::uint8_t> greys = converter_ ? std::span<std::uint8_t>(scanned_) : pixels;
  speckle_->set_place(exposure.place);
  for (std::uint32_t sample = 0; sample < samples_in_line_; ++sample)
    draw_samples(sample, greys.subspan(sample * lines_.size(), lines_.size()));
  if (converter_) converter_->draw(scanned_, pixels);
}

/// Writes one sample of all lines to blurred_: the main lobe's three lines, the side lobes, and
/// reverberation.
void BodyFrames::blur_across(std::uint32_t sample) {
  const std::size_t lines = lines_.size();
  const auto power = [&](std::size_t line) { return power_[line * line_stride_ + sample]; };
  for (std::size_t line = 0; line < lines; ++line) {
    const std::size_t before = line == 0 ? 0 : line - 1;
    const std::size_t behind = std::min(line + 1, lines - 1);
    blurred_[line] = 0.25F * (power(before) + power(behind)) + 0.5F * power(line) + reverberation_[sample];
    sums_[line + 1] = sums_[line] + power(line);
  }
  if (lobe_lines_ == 0) return;
  for (std::size_t line = 0; line < lines; ++line) {
    const std::size_t first = line - std::min<std::size_t>(line, lobe_lines_);
    const std::size_t end = std::min<std::size_t>(line + lobe_lines_ + 1, lines);
    const double mean = (sums_[end] - sums_[first]) / static_cast<double>(end - first);
    blurred_[line] += kLobePower * static_cast<float>(mean);
  }
}

/// One sample of each line.
void BodyFrames::draw_samples(std::uint32_t sample, std::span<std::uint8_t> greys) {
  blur_across(sample);
  const std::span<const std::uint8_t> factors = speckle_->row(sample);
  const bool log = scale_.kind == EchoScale::Kind::kLog;
  constexpr std::int32_t kOne = FrameSpeckle::kOne;
  for (std::uint32_t line = 0; line < greys.size(); ++line) {
    const std::int32_t mean = greys_[std::bit_cast<std::uint32_t>(blurred_[line]) >> 16];
    const std::uint32_t factor = factors[line];
    const std::int32_t grey =
        log ? mean + speckle_greys_[factor] : (mean * static_cast<std::int32_t>(factor) + kOne / 2) / kOne;
    greys[line] = static_cast<std::uint8_t>(std::clamp(grey, 0, 255));
  }
}

}  // namespace fanlight
