// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/first_sweeps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "acquisition/igtl/sweep_lengths.hpp"
#include "acquisition/sequence/recorded_stream.hpp"
#include "acquisition/sequence/recording_geometry.hpp"
#include "acquisition/sequence/sector_guess.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/base/printable.hpp"
#include "proto/igtl/pose_bodies.hpp"

namespace fanlight {

namespace {

constexpr std::uint32_t kMostFramesASweep = 4096;
constexpr std::uint64_t kMostVolumeBytes = std::uint64_t{2} << 30;
// A fit takes time that grows with the images: not after each.
constexpr std::size_t kImagesAFit = 16;
// This number of images must have a place or an angle.
constexpr double kLeastShare = 0.9;
// More images add nothing; the oldest are dropped.
constexpr std::size_t kMostImages = 2048;
constexpr double kLeastTurnDeg = 1;  // of transforms
constexpr double kNoTiltDeg = 0.1;
constexpr double kMostDisagreementDeg = 1;

using Vector = std::array<double, 3>;

double length(const Vector& vector) {
  return std::hypot(vector[0], vector[1], vector[2]);
}

/// The largest angle between the axes of two poses.
double turn_deg(const igtl::GridPose& one, const igtl::GridPose& other) {
  double most = 0;
  for (const auto axis : {&igtl::GridPose::i_mm, &igtl::GridPose::j_mm, &igtl::GridPose::k_mm}) {
    const Vector& a = one.*axis;
    const Vector& b = other.*axis;
    const double lengths = length(a) * length(b);
    const double cosine = lengths > 0 ? (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / lengths : 1;
    most = std::max(most, degrees(std::acos(std::clamp(cosine, -1.0, 1.0))));
  }
  return most;
}

double tilt_deg(const FanFit& fit) {
  const auto [smallest, largest] = std::ranges::minmax(fit.angles_rad);
  return degrees(largest - smallest);
}

}  // namespace

FirstSweeps::FirstSweeps(const IgtlAddress& address, std::filesystem::path geometry_path,
                         const PoseHistory& poses)
    : address_(address), geometry_path_(std::move(geometry_path)), poses_(poses) {}

FrameSize FirstSweeps::size() const {
  return frame_size(first_, address_.orientation);
}

void FirstSweeps::add(const IgtlImage& image) {
  const PixelFormat format = *pixel_format(image.body);
  if (seen_.empty() || image.body.size != first_.size || format != format_) {
    seen_.clear();
    format_ = format;
    brightest_.assign(std::size_t{image.body.size[0]} * image.body.size[1], 0);
    grey_.resize(brightest_.size());
    levels_.emplace(format, whole_window(format));
    values_ = format.is_grey() ? std::nullopt : std::optional(ValueHistogram(format));
  }
  first_ = image.body;
  if (seen_.size() == kMostImages) seen_.erase(seen_.begin(), seen_.begin() + kMostImages / 2);
  seen_.push_back({image.notes, image.body.pose, image.time_ns});
  levels_->convert(image.pixels, grey_);
  for (std::size_t i = 0; i < grey_.size(); ++i) brightest_[i] = std::max(brightest_[i], grey_[i]);
  if (values_) values_->add(image.pixels);
  fields_.clear();
  image.metadata.for_each([this](std::string_view name, std::string_view value) {
    constexpr std::size_t kMostFields = 64;
    if (name.starts_with("Fanlight") && fields_.size() < kMostFields)
      fields_[std::string(name)] = printable(value.substr(0, 256));
  });
}

Result<std::optional<LearnedFan>> FirstSweeps::result(bool at_once) {
  if (seen_.empty()) return std::optional<LearnedFan>();
  if (is_told()) {
    auto fan = described_fan();
    if (!fan) return fan.error();
    return std::optional(*std::move(fan));
  }
  if (!at_once && seen_.size() % kImagesAFit != 0) return std::optional<LearnedFan>();
  return found(at_once);
}

bool FirstSweeps::is_told() const {
  const FrameNotes& notes = seen_.back().notes;
  const auto facts = recording_facts(fields_);
  if (!facts || !notes.angle_rad || !notes.sequence || !format_.is_grey()) return false;
  return !facts->counts_volumes || (notes.volume_index && notes.frame_index && notes.direction);
}

Result<LearnedFan> FirstSweeps::described_fan() const {
  const RecordingFacts facts = *recording_facts(fields_);
  LearnedFan fan{.format = format_, .sequence_named = true, .is_fanlight = true};
  fan.source = {.counts_volumes = facts.counts_volumes,
                .frames_per_volume = facts.frames_per_volume,
                .usual_frames = std::min(facts.usual_frames, kMostFramesASweep),
                .first_angle_rad = facts.first_angle_rad,
                .last_angle_rad = facts.last_angle_rad,
                .simulated = facts.simulated};
  if (auto added = add_geometry(fan); !added) return added.error();
  fan.source.notes.push_back(
      fmt::format("The frames come from another Fanlight, whose source is {}.", facts.source));
  return fan;
}

Result<std::optional<LearnedFan>> FirstSweeps::found(bool at_once) const {
  LearnedFan fan{.format = format_};
  Angles angles_rad(seen_.size());
  auto known = find_angles(fan, angles_rad);
  if (!known) {
    // Images that do not turn yet may do so later.
    if (at_once) return known.error();
    return std::optional<LearnedFan>();
  }
  std::vector<FrameNotes> notes;
  notes.reserve(seen_.size());
  for (const Seen& each : seen_) notes.push_back(each.notes);
  const SweepLengths lengths = sweep_lengths(notes, angles_rad);
  if (!lengths.enough && !at_once) return std::optional<LearnedFan>();
  fan.sequence_named =
      std::ranges::all_of(notes, [](const FrameNotes& each) { return each.sequence.has_value(); });
  fan.source.counts_volumes = lengths.counted;
  fan.source.usual_frames = lengths.longest;
  fan.source.frames_per_volume = lengths.capacity;
  fan.source.first_angle_rad = lengths.smallest_rad;
  fan.source.last_angle_rad = lengths.largest_rad;
  if (!(lengths.largest_rad > lengths.smallest_rad)) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: the angles of {} images are all alike, expected a sweep", address_.text(),
                             seen_.size())};
  }
  if (values_) fan.window = values_->window();
  if (auto added = add_geometry(fan); !added) return added.error();
  if (!lengths.enough) {
    fan.source.notes.push_back(
        fmt::format("No whole sweep was seen in the first {} images: the range of the angles may be wider.",
                    seen_.size()));
  }
  return std::optional(std::move(fan));
}

Result<void> FirstSweeps::find_angles(LearnedFan& fan, Angles& angles_rad) const {
  std::size_t named = 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    angles_rad[i] = seen_[i].notes.angle_rad;
    if (angles_rad[i]) ++named;
  }
  if (static_cast<double>(named) >= kLeastShare * static_cast<double>(seen_.size())) return {};
  return fit(fan, angles_rad);
}

/// The positions that a device's transforms give the images, or their own matrices, and the fan through them.
/// nullopt: they do not turn, or most images have none.
std::optional<FirstSweeps::Candidate> FirstSweeps::candidate(std::optional<std::size_t> device) const {
  Candidate found{.device = device};
  std::vector<ImagePose> poses;
  double most_turn_deg = 0;
  std::optional<igtl::GridPose> first;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    igtl::GridPose grid = seen_[i].matrix;
    if (device) {
      const auto placed = poses_.at(*device, seen_[i].time_ns).pose;
      if (!placed) continue;
      if (!first) first = placed;
      most_turn_deg = std::max(most_turn_deg, turn_deg(*first, *placed));
      grid = igtl::composed(*placed, grid);
    }
    const auto pose = frame_pose(grid, address_.orientation, size());
    if (!pose) continue;
    poses.push_back(*pose);
    found.of.push_back(i);
  }
  const bool enough = static_cast<double>(poses.size()) >= kLeastShare * static_cast<double>(seen_.size());
  // Images that turn by themselves turn in the frame of reference of a tool at rest, too: that tool moves
  // them not at all now, and wrongly later.
  if (!enough || (device && most_turn_deg < kLeastTurnDeg)) return std::nullopt;
  auto fitted = fit_fan(poses, (size().columns - 1) / 2.0);
  if (!fitted) return std::nullopt;
  found.fit = *std::move(fitted);
  if (tilt_deg(found.fit) < kNoTiltDeg) return std::nullopt;
  found.why_not = why_no_fan(found.fit);
  return found;
}

/// Images' own matrices come first. Of the transforms, those that miss the images least; where none form a
/// fan, those that turn most.
std::optional<FirstSweeps::Candidate> FirstSweeps::best_candidate() const {
  std::optional<Candidate> best;
  if (address_.transform.empty()) best = candidate(std::nullopt);
  if (best && best->why_not.empty()) return best;
  for (std::size_t device = 0; device < poses_.devices(); ++device) {
    if (!address_.transform.empty() && poses_.name(device).view() != address_.transform) continue;
    auto other = candidate(device);
    if (!other) continue;
    const bool fan = other->why_not.empty();
    const bool better = !best || (fan != best->why_not.empty() ? fan
                                  : fan ? other->fit.residual_mm < best->fit.residual_mm
                                        : tilt_deg(other->fit) > tilt_deg(best->fit));
    if (better) best = std::move(other);
  }
  return best;
}

Result<void> FirstSweeps::fit(LearnedFan& fan, Angles& angles_rad) const {
  auto best = best_candidate();
  if (!best) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: the images have no angles, expected MotorAngleDeg in the metadata of "
                             "each, or matrices of theirs, or transforms, that turn",
                             address_.text())};
  }
  const std::string origin =
      best->device ? fmt::format("the transforms {}", printable(poses_.name(*best->device).view()))
                   : "their matrices";
  if (!best->why_not.empty()) {
    return Error{ErrorCode::kUnsupported, fmt::format("{}: the places of the images, by {}, form no fan: {}",
                                                      address_.text(), origin, best->why_not)};
  }
  for (std::size_t i = 0; i < best->of.size(); ++i) angles_rad[best->of[i]] = best->fit.angles_rad[i];
  fan.angles = best->device ? LearnedFan::Angles::kTransforms : LearnedFan::Angles::kMatrices;
  if (best->device) fan.device = poses_.name(*best->device);
  fan.centre_column = (size().columns - 1) / 2.0;
  fan.source.notes.push_back(fmt::format(
      "The fan is from {}: an axis was fitted to {} images, which it misses by {:.2f} mm; they slide by "
      "{:.2f} mm along it and turn by {:.2f} deg out of the fan (root mean squares).",
      origin, best->of.size(), best->fit.residual_mm, best->fit.slide_mm, best->fit.turn_deg));
  fan.fit = std::move(best->fit);
  return {};
}

/// Whether angles that were fitted differ from those that are named by a constant alone: else the places are
/// of another motion, such as a hand's.
bool FirstSweeps::agree(const Angles& fitted_rad) const {
  std::vector<double> differences;
  for (std::size_t i = 0; i < seen_.size(); ++i)
    if (fitted_rad[i] && seen_[i].notes.angle_rad)
      differences.push_back(*fitted_rad[i] - *seen_[i].notes.angle_rad);
  if (differences.empty()) return false;
  const auto count = static_cast<double>(differences.size());
  const double mean = std::accumulate(differences.begin(), differences.end(), 0.0) / count;
  double squares = 0;
  for (const double each : differences) squares += (each - mean) * (each - mean) / count;
  return degrees(std::sqrt(squares)) <= kMostDisagreementDeg;
}

Result<void> FirstSweeps::add_geometry(LearnedFan& fan) const {
  FrameSequence images;
  images.columns = size().columns;
  images.rows = size().rows;
  images.fanlight_fields = fields_;
  double across_mm = length(first_.pose.i_mm);
  double down_mm = length(first_.pose.j_mm);
  if (address_.orientation.lines_in_rows) std::swap(across_mm, down_mm);
  const bool sized = across_mm > 0 && down_mm > 0;
  if (sized) images.pixel_size = {.width_mm = across_mm, .height_mm = down_mm};
  images.pixel_size_origin = "the images' matrix";
  if (!fan.is_fanlight) add_guesses(images.fanlight_fields, fan, sized ? across_mm / down_mm : 1, down_mm);
  // Named angles leave the radius open; places that form a fan determine it.
  bool fitted = fan.angles != LearnedFan::Angles::kNamed;
  LearnedFan placed;
  Angles fitted_rad(seen_.size());
  if (!fitted && !images.fanlight_fields.contains("FanlightMotorRadiusMm") && fit(placed, fitted_rad) &&
      agree(fitted_rad)) {
    fitted = true;
    fan.fit = placed.fit;
    fan.source.notes.push_back("The angles are those of the metadata. " + placed.source.notes.front());
  }
  const auto found =
      find_geometry(address_.text(), images, geometry_path_, fitted ? std::optional(fan.fit) : std::nullopt);
  if (!found) return found.error();
  fan.source.geometry = found->geometry;
  std::ranges::copy(found->suspicions, std::back_inserter(fan.source.notes));
  if (found->window_black) fan.window = {*found->window_black, *found->window_white};
  if (!format_.is_grey()) {
    fan.source.notes.push_back(fmt::format(
        "The pixels have {}: values from {} to {} are shown from black to white, {}.", format_.name(),
        fan.window.black, fan.window.white,
        found->window_black
            ? "as the geometry says"
            : "chosen by the first images; window_black and window_white in --geometry set them"));
  }
  if (fitted) {
    fan.source.notes.push_back(
        fmt::format("The axis lies {:.1f} mm behind the probe's face.", found->geometry.motor_radius_mm));
  }
  const std::uint64_t volume_bytes = found->geometry.frame_bytes() * fan.source.frames_per_volume;
  if (fan.source.frames_per_volume < 2 || fan.source.frames_per_volume > kMostFramesASweep ||
      volume_bytes > kMostVolumeBytes) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{}: a sweep has {} frames of {} bytes, expected 2 to {} frames and up to 2 GB",
                             address_.text(), fan.source.frames_per_volume, found->geometry.frame_bytes(),
                             kMostFramesASweep)};
  }
  fan.fit.angles_rad.clear();
  return {};
}

/// What the images do not say is taken from their content: the place of the probe's face, and its radius.
void FirstSweeps::add_guesses(Fields& fields, LearnedFan& fan, double column_rows, double row_mm) const {
  const auto kind = fields.find("FanlightFrameKind");
  if (kind != fields.end() && kind->second != kFrameKindNames[0]) return;
  const bool face_told = fields.contains("FanlightFaceRow") && fields.contains("FanlightFaceColumn");
  if (face_told || address_.orientation.lines_in_rows) return;
  const FrameSize frame = size();
  std::vector<std::uint8_t> bright(brightest_.size());
  arrange_frame(brightest_, address_.orientation, frame, bright);
  if (const int most = std::ranges::max(bright); most > 0)
    for (std::uint8_t& each : bright) each = static_cast<std::uint8_t>(each * 255 / most);
  const auto sector = guess_sector(bright, frame.columns, frame.rows, column_rows);
  const auto give = [&fields](const char* name, double value) {
    fields.emplace(name, fmt::format("{}", value));
  };
  give("FanlightFaceColumn", sector ? sector->face_column : (frame.columns - 1) / 2.0);
  give("FanlightFaceRow", sector ? sector->face_row : 0);
  if (!sector) {
    fan.source.notes.emplace_back(
        "The probe's face is taken to be the middle of the images' first row: they show no edge of it.");
    return;
  }
  if (sector->diverges) {
    const double radius_mm = (sector->face_row - sector->apex_row) * row_mm;
    give("FanlightProbeRadiusMm", radius_mm);
    give("FanlightSectorHalfAngleDeg", sector->half_angle_deg);
    give("FanlightSectorReachMm", (sector->last_row - sector->apex_row) * row_mm);
    fan.source.notes.push_back(fmt::format(
        "The probe's face and its radius of {:.1f} mm are guessed by the edges of the images.", radius_mm));
  } else {
    fan.source.notes.emplace_back("The probe's face is guessed by the edges of the images.");
  }
}

}  // namespace fanlight
