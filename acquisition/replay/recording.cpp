// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "acquisition/record/recover_recording.hpp"
#include "acquisition/replay/given_fields.hpp"
#include "acquisition/replay/seen_sector.hpp"
#include "acquisition/sequence/tracked_poses.hpp"
#include "acquisition/source/angle_check.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr double kHysteresisRad = radians(1.0);
constexpr double kLeastSpreadDeg = 0.01;
constexpr double kLongestS = 1e6;
// A larger gap of FrameIndex is a different numbering and no loss.
constexpr std::uint32_t kMostLost = 1000;

/// Number of frames that have a field, and the first one without it.
struct Coverage {
  std::size_t present = 0;
  std::size_t first_missing = 0;
};

template <typename T>
Coverage coverage(const std::vector<SequenceFrame>& frames, std::optional<T> SequenceFrame::*field) {
  const auto present = [field](const SequenceFrame& frame) { return (frame.*field).has_value(); };
  const auto missing = std::ranges::find_if_not(frames, present);
  return {static_cast<std::size_t>(std::ranges::count_if(frames, present)),
          static_cast<std::size_t>(missing - frames.begin())};
}

Result<ValueWindow> window_of(const Recording::Config& config, const RecordingGeometry& geometry) {
  if (geometry.window_black) return ValueWindow{*geometry.window_black, *geometry.window_white};
  return choose_window(config.path, config.max_bytes, geometry.unscanned);
}

/// Finds what was not scanned, where the geometry leaves that to the pixels.
Result<void> find_unscanned(const Recording::Config& config, RecordingGeometry& geometry,
                            OpenedSequence& opened) {
  if (geometry.unscanned == Unscanned::kNone) return {};
  std::vector<std::string>& notes = opened.sequence.notes;
  if (opened.sequence.is_grid) {
    UnscannedPixels unscanned = opened.pixels.mark_unscanned(geometry.unscanned);
    geometry.geometry.zero_is_unscanned = unscanned.code.has_value();
    if (!unscanned.note.empty()) notes.push_back(std::move(unscanned.note));
  } else if (geometry.unscanned == Unscanned::kDetect) {
    const auto seen = see_sector(config.path, config.max_bytes, geometry.geometry);
    if (!seen) return seen.error();
    if (!*seen) return {};
    geometry.geometry = **seen;
    notes.push_back(note_on_seen_sector(geometry.geometry));
  }
  return {};
}

// A usual sweep has 20 to 90 deg; this is 2.6 rad, taken for degrees.
constexpr double kLeastFanDeg = 2.6;

}  // namespace

Recording::Recording(const Config& config, OpenedSequence opened)
    : sequence_(std::move(opened.sequence)),
      pixels_(std::move(opened.pixels)),
      frames_(sequence_.frames.size()) {
  summary_.name = shown(config.path);
  for (std::size_t i = 0; i < frames_.size(); ++i) frames_[i].valid = sequence_.frames[i].valid;
}

Result<Recording> Recording::open(const Config& config) {
  std::optional<FinishedRecording> recovered;
  if (is_unfinished(config.path)) {
    auto mended = recover_recording(config.path, {});
    if (!mended) return mended.error();
    recovered = *std::move(mended);
  }
  auto opened = open_recording_file(config.path, config.max_bytes);
  if (!opened) return opened.error();
  const auto fit = fit_poses(config.path, opened->sequence, opened->orientation);
  if (!fit) return fit.error();
  if (const auto fan = refuse_tracked_by_hand(config.path, opened->sequence); !fan) return fan.error();
  auto geometry = find_geometry(config.path, opened->sequence, config.geometry_path, *fit);
  if (!geometry) return geometry.error();
  if (auto found = find_unscanned(config, *geometry, *opened); !found) return found.error();
  const auto given = fill_from_geometry(config.path, *geometry, opened->sequence);
  if (!given) return given.error();
  ValueWindow window;
  if (!opened->sequence.format.is_grey()) {
    const auto found = window_of(config, *geometry);
    if (!found) return found.error();
    window = *found;
    opened->pixels.set_window(window);
  }
  if (config.pixels == Pixels::kAll) {
    if (const auto read = read_all(*opened); !read) return read.error();
  }

  Recording recording(config, *std::move(opened));
  recording.angles_given_ = *given;
  if (const auto read = recording.read_first_frame(); !read) return read.error();
  if (const auto done = recording.find_times(); !done) return done.error();
  if (const auto done = recording.find_angles_and_sweeps(*geometry); !done) return done.error();
  recording.summary_.window = window;
  recording.find_directions();
  recording.find_lost_frames();
  if (const auto done = recording.summarise(*geometry); !done) return done.error();
  if (recovered) recording.add_note(*recovered);
  return recording;
}

Result<void> Recording::read_first_frame() {
  if (sequence_.pixels == nullptr) {
    first_frame_.resize(sequence_.frame_bytes());
    if (auto read = pixels_->read(0, first_frame_); !read) return read;
  }
  transposed_ = pixels_->looks_transposed();
  if (sequence_.pixels != nullptr) pixels_.reset();
  return {};
}

Result<void> Recording::read_frame(std::size_t frame, std::span<std::uint8_t> to) {
  if (pixels_ && frame > 0) return pixels_->read(frame, to);
  std::ranges::copy(pixels_ ? std::span<const std::uint8_t>(first_frame_) : frame_pixels(frame), to.begin());
  return {};
}

Result<void> Recording::finish() {
  // Frames that were not requested are not read for the sake of the checksum.
  return pixels_ && pixels_->at_end() ? pixels_->finish() : Result<void>();
}

Result<void> Recording::check_pixels() {
  const std::uint64_t bytes = sequence_.frame_bytes() * sequence_.frames.size();
  if (has_quick_access() || bytes > kMostChecked) return {};
  // Frames before the last one are read over.
  std::vector<std::uint8_t> last(sequence_.frame_bytes());
  if (auto read = pixels_->read(sequence_.frames.size() - 1, last); !read) return read;
  return finish();
}

Result<void> Recording::find_times() {
  const auto& fields = sequence_.frames;
  if (fields.size() < 2) return bad("there is a single frame", "a sweep of 2 at least");
  const auto [present, missing] = coverage(fields, &SequenceFrame::timestamp_s);
  if (present < fields.size())
    return bad(
        fmt::format("frame {} has no Timestamp", missing),
        present == 0 ? "one for each frame, or frames_per_second in the geometry" : "one for each frame");
  const double start_s = *fields[0].timestamp_s;
  for (std::size_t i = 1; i < fields.size(); ++i) {
    const double since_start_s = *fields[i].timestamp_s - start_s;
    if (*fields[i].timestamp_s < *fields[i - 1].timestamp_s || since_start_s > kLongestS) {
      return bad(fmt::format("frame {} comes {} s after the first, out of order", i, since_start_s),
                 fmt::format("Timestamps that rise, by at most {} s", kLongestS));
    }
    frames_[i].time_ns = std::llround(since_start_s * 1e9);
  }
  if (frames_.back().time_ns == 0) return bad("all frames have the same Timestamp", "times that rise");
  return {};
}

/// A frame that came out of order stays in the sweep it came in; only forward passes play it.
void Recording::cut_as_recorded() {
  std::uint64_t next_sequence = 0;
  for (std::uint32_t i = 0; i < frames_.size(); ++i) {
    const RecordedFrame& frame = stream_->frames[i];
    const bool in_order = i == 0 || frame.stamp.after_interruption || frame.stamp.sequence >= next_sequence;
    frames_[i].angle_rad = frame.stamp.angle_rad;
    frames_[i].valid = frame.usable() && in_order;
    if (!in_order) continue;
    next_sequence = frame.stamp.sequence + 1;
    const bool further = !sweeps_.empty() && frame.stamp.volume_index > sweeps_.back().volume_index;
    if (stream_->facts.counts_volumes && (i == 0 || further)) begin_sweep(i, frame.stamp.volume_index);
  }
  if (!stream_->facts.counts_volumes) cut_at_turning_points();
}

Result<void> Recording::find_angles_and_sweeps(const RecordingGeometry& geometry) {
  const auto& fields = sequence_.frames;
  stream_ = recorded_stream(sequence_);
  if (stream_) {
    cut_as_recorded();
    close_sweeps();
    return {};
  }
  measured_ = coverage(fields, &SequenceFrame::motor_angle_deg).present > 0;
  if (measured_) {
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (!fields[i].motor_angle_deg && fields[i].valid) {
        return bad(fmt::format("frame {} has no MotorAngleDeg", i), "one for each valid frame");
      }
      frames_[i].angle_rad = radians(fields[i].motor_angle_deg.value_or(0));
    }
  } else if (!geometry.first_angle_deg || !geometry.last_angle_deg) {
    return bad("no frame has a MotorAngleDeg",
               "one for each frame, or angles_deg, or first_angle_deg and last_angle_deg in the geometry");
  }

  if (coverage(fields, &SequenceFrame::volume_index).present > 0) {
    if (const auto done = cut_at_volume_index(); !done) return done.error();
  } else if (measured_) {
    // Before the sweeps are known: an outlier would be two turning points.
    exclude_spikes();
    cut_at_turning_points();
  } else {
    begin_sweep(0, 0);
  }
  close_sweeps();
  if (measured_) exclude_outliers();
  if (!measured_) spread_angles(*geometry.first_angle_deg, *geometry.last_angle_deg);
  return {};
}

Result<void> Recording::cut_at_volume_index() {
  const auto& fields = sequence_.frames;
  const auto [present, missing] = coverage(fields, &SequenceFrame::volume_index);
  if (present < fields.size()) {
    return bad(fmt::format("frame {} has no VolumeIndex", missing), "one for each frame, or for none");
  }
  for (std::uint32_t i = 0; i < fields.size(); ++i) {
    const std::uint64_t index = *fields[i].volume_index;
    if (i > 0 && index < sweeps_.back().volume_index) {
      return bad(fmt::format("the VolumeIndex of frame {} goes back from {} to {}", i,
                             sweeps_.back().volume_index, index),
                 "indices that never fall");
    }
    if (i == 0 || index != sweeps_.back().volume_index) begin_sweep(i, index);
  }
  if (sweeps_.size() == frames_.size())
    return bad("each frame has a VolumeIndex of its own", "sweeps of 2 frames at least");
  return {};
}

/// Single frames beyond both of their neighbours, which agree. Sweeps may differ in speed.
void Recording::exclude_spikes() {
  constexpr double kMostOfNeighbours = 0.2;
  for (std::size_t i = 1; i + 1 < frames_.size(); ++i) {
    const double before_rad = frames_[i].angle_rad - frames_[i - 1].angle_rad;
    const double after_rad = frames_[i + 1].angle_rad - frames_[i].angle_rad;
    const double size_rad = std::min(std::abs(before_rad), std::abs(after_rad));
    const bool turns_twice = before_rad * after_rad < 0 && size_rad > kHysteresisRad;
    if (!turns_twice || !frames_[i - 1].valid || !frames_[i].valid || !frames_[i + 1].valid) continue;
    if (std::abs(before_rad + after_rad) > kMostOfNeighbours * size_rad) continue;
    // A motor that turns leaves its extreme as slowly as it came: the steps next to a spike are smaller.
    const bool steady_before =
        i < 2 || std::abs(frames_[i - 1].angle_rad - frames_[i - 2].angle_rad) < size_rad / 3;
    const bool steady_after = i + 2 >= frames_.size() ||
                              std::abs(frames_[i + 2].angle_rad - frames_[i + 1].angle_rad) < size_rad / 3;
    if (!steady_before || !steady_after) continue;
    frames_[i].valid = false;
    ++summary_.angle_outliers;
  }
}

void Recording::exclude_outliers() {
  for (const Sweep& sweep : sweeps_) exclude_outliers(sweep.first_frame, sweep.first_frame + sweep.frames);
}

void Recording::exclude_outliers(std::uint32_t first_frame, std::uint32_t end_frame) {
  std::vector<AngleCheck::Frame> to_check;
  std::vector<std::uint32_t> indices;
  std::uint64_t sequence = 0;
  for (std::uint32_t i = first_frame; i < end_frame; ++i) {
    sequence += 1 + (i > first_frame ? lost_before(i) : 0);
    if (!frames_[i].valid || std::abs(frames_[i].angle_rad) >= kPi / 2) continue;
    to_check.push_back({.sequence = sequence, .angle_rad = frames_[i].angle_rad});
    indices.push_back(i);
  }
  AngleCheck check(to_check.size());
  for (const std::size_t outlier : check.check(to_check).outliers) {
    frames_[indices[outlier]].valid = false;
    ++summary_.angle_outliers;
  }
}

void Recording::cut_at_turning_points() {
  begin_sweep(0, 0);
  // Extreme angle of the open sweep: the first frame that reached it.
  std::optional<std::uint32_t> extreme;
  double direction = 0;  // +1 or -1; 0 until the angle has moved
  for (std::uint32_t i = 0; i < frames_.size(); ++i) {
    if (!frames_[i].valid) continue;
    if (!extreme) extreme = i;
    const double beyond_rad = frames_[i].angle_rad - frames_[*extreme].angle_rad;
    if (direction == 0) {
      if (std::abs(beyond_rad) < kHysteresisRad) continue;
      direction = beyond_rad > 0 ? 1 : -1;
      extreme = i;
    } else if (direction * beyond_rad > 0) {
      extreme = i;
    } else if (direction * beyond_rad <= -kHysteresisRad) {
      begin_sweep(*extreme + 1, static_cast<std::uint32_t>(sweeps_.size()));
      direction = -direction;
      extreme = i;
    }
  }
}

void Recording::begin_sweep(std::uint32_t first_frame, std::uint64_t volume_index) {
  sweeps_.push_back({.first_frame = first_frame, .volume_index = volume_index});
}

void Recording::close_sweeps() {
  for (std::uint32_t sweep = 0; sweep < sweeps_.size(); ++sweep) {
    const std::uint32_t first = sweeps_[sweep].first_frame;
    const bool last = sweep + 1 == sweeps_.size();
    const auto end = last ? static_cast<std::uint32_t>(frames_.size()) : sweeps_[sweep + 1].first_frame;
    sweeps_[sweep].frames = end - first;
    for (std::uint32_t i = first; i < end; ++i) frames_[i].sweep = sweep;
  }
}

void Recording::spread_angles(double first_deg, double last_deg) {
  for (const Sweep& sweep : sweeps_) {
    const auto stated = sequence_.frames[sweep.first_frame].direction;
    const bool backward = stated == SweepDirection::kBackward;
    for (std::uint32_t i = 0; i < sweep.frames; ++i) {
      const std::uint32_t position = backward ? sweep.frames - 1 - i : i;
      const double share = sweep.frames == 1 ? 0.5 : static_cast<double>(position) / (sweep.frames - 1);
      frames_[sweep.first_frame + i].angle_rad = radians(std::lerp(first_deg, last_deg, share));
    }
  }
}

void Recording::find_directions() {
  for (Sweep& sweep : sweeps_) {
    const auto frames = std::span(frames_).subspan(sweep.first_frame, sweep.frames);
    const auto first = std::ranges::find_if(frames, &Frame::valid);
    const auto last =
        std::find_if(frames.rbegin(), frames.rend(), [](const Frame& frame) { return frame.valid; });
    const bool falling = first != frames.end() && last->angle_rad < first->angle_rad;
    sweep.direction = falling ? SweepDirection::kBackward : SweepDirection::kForward;
    const auto stated = sequence_.frames[sweep.first_frame].direction;
    // A single frame, as where a recording begins at the end of a sweep, has no direction of its own.
    const bool told = measured_ && first != frames.end() && last->angle_rad != first->angle_rad;
    if (told && stated && *stated != sweep.direction) ++contradictions_;
    if (!told && stated) sweep.direction = *stated;
  }
}

void Recording::find_lost_frames() {
  for (std::size_t i = 1; i < frames_.size(); ++i) {
    if (frames_[i].sweep == frames_[i - 1].sweep) frames_[i].lost_before = lost_before(i);
  }
}

/// Frames that were lost between this one and the one before it, by their FrameIndex.
std::uint32_t Recording::lost_before(std::size_t frame) const {
  const auto before = sequence_.frames[frame - 1].frame_index;
  const auto index = sequence_.frames[frame].frame_index;
  if (!before || !index || *index <= *before) return 0;
  const std::uint32_t lost = *index - *before - 1;
  return lost <= kMostLost ? lost : 0;
}

Result<void> Recording::summarise(const RecordingGeometry& geometry) {
  double smallest_deg = std::numeric_limits<double>::infinity();
  double largest_deg = -smallest_deg;
  for (const Frame& frame : frames_) {
    if (!frame.valid) ++summary_.frames_invalid;
    summary_.frames_lost += frame.lost_before;
    // The assembler rejects frames with angles out of this range.
    const double angle_deg = degrees(frame.angle_rad);
    if (!frame.valid || std::abs(angle_deg) >= 90) continue;
    smallest_deg = std::min(smallest_deg, angle_deg);
    largest_deg = std::max(largest_deg, angle_deg);
  }
  if (smallest_deg > largest_deg) return bad("no frame is usable", "valid frames at less than 90 deg");
  if (largest_deg - smallest_deg < kLeastSpreadDeg) {
    return bad(fmt::format("the motor angle stays at {} deg", smallest_deg), "a sweep");
  }

  summary_.frames = static_cast<std::uint32_t>(frames_.size());
  summary_.columns = sequence_.columns;
  summary_.rows = sequence_.rows;
  summary_.compressed = sequence_.compressed;
  summary_.format = sequence_.format;
  summary_.sweeps = static_cast<std::uint32_t>(sweeps_.size());
  summary_.frames_in_longest_sweep = std::ranges::max_element(sweeps_, {}, &Sweep::frames)->frames;
  summary_.smallest_angle_deg = smallest_deg;
  summary_.largest_angle_deg = largest_deg;
  summary_.duration_s = static_cast<double>(frames_.back().time_ns) * 1e-9;
  summary_.frame_rate_hz = static_cast<double>(frames_.size() - 1) / summary_.duration_s;
  summary_.geometry = geometry.geometry;
  summary_.geometry_values = geometry.values;
  add_notes(geometry);
  return {};
}

Error Recording::bad(std::string_view wrong, std::string_view expected) const {
  return {ErrorCode::kBadInput, fmt::format("{}: {}, expected {}", summary_.name, wrong, expected)};
}

void Recording::add_notes(const RecordingGeometry& geometry) {
  std::vector<std::string>& notes = summary_.notes;
  notes = sequence_.notes;
  for (const auto* sentences : {&geometry.contradictions, &geometry.suspicions})
    notes.insert(notes.end(), sentences->begin(), sentences->end());
  const double span_deg = summary_.largest_angle_deg - summary_.smallest_angle_deg;
  if (const auto& fit = geometry.fit) {
    notes.push_back(
        fmt::format("The motor angles are fitted to the poses of the frames: the best axis lies {:.1f} mm "
                    "behind row 0 and misses "
                    "the frames by {:.1f} mm (root mean square).",
                    -fit->axis_mm, fit->residual_mm));
  }
  if (!measured_) {
    notes.push_back(
        fmt::format("The motor angles are assumed: the frames have none, and are spread evenly from {} to {} "
                    "deg as the geometry says.",
                    *geometry.first_angle_deg, *geometry.last_angle_deg));
  } else if (angles_given_) {
    notes.emplace_back(
        geometry.sweep_starts_deg.empty()
            ? "The motor angles are the angles_deg of the geometry: the frames have none."
            : "The motor angles are those of the geometry, each sweep from its sweep_starts_deg on: the "
              "frames have none.");
  } else if (geometry.first_angle_deg || geometry.last_angle_deg) {
    notes.emplace_back(
        "first_angle_deg and last_angle_deg of the geometry are not used: the frames have a MotorAngleDeg.");
  }
  if (!summary_.format.is_grey()) {
    notes.push_back(
        fmt::format("The pixels are {}: {} is shown black and {} white, {}.", summary_.format.name(),
                    summary_.window.black, summary_.window.white,
                    geometry.window_black
                        ? "as the geometry says"
                        : "chosen from their values; window_black and window_white in the geometry set it"));
  } else if (geometry.window_black) {
    notes.emplace_back(
        "window_black and window_white of the geometry are not used: the pixels are grey levels.");
  }
  if (summary_.angle_outliers > 0) {
    notes.push_back(fmt::format("{} of {} frames are left out: their angle is an outlier.",
                                summary_.angle_outliers, summary_.frames));
  }
  if (measured_ && !stream_ && !sequence_.is_grid && span_deg < kLeastFanDeg) {
    notes.push_back(fmt::format(
        "All angles lie within {:.2f} deg. MotorAngleDeg is in degrees: are these radians?", span_deg));
  }
  if (contradictions_ > 0) {
    notes.push_back(
        fmt::format("The SweepDirection of {} of {} sweeps contradicts their angles, which count.",
                    contradictions_, summary_.sweeps));
  }
  if (transposed_) {
    notes.push_back(
        fmt::format("The frames look like {} columns and {} rows: are the first two numbers of DimSize "
                    "exchanged?",
                    sequence_.rows, sequence_.columns));
  }
}

void Recording::add_note(const FinishedRecording& recovered) {
  summary_.notes.push_back(fmt::format(
      "The recording was cut off, and was finished now with {} frames; {} of them are damaged, {} more "
      "are lost.",
      recovered.frames, recovered.frames_damaged, recovered.frames_lost));
}

}  // namespace fanlight
