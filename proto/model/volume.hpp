// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "proto/model/fan_geometry.hpp"
#include "proto/model/frame.hpp"
#include "proto/model/sweep_warnings.hpp"

namespace fanlight {

/// Identity and time of one volume; small enough to be copied into each picture made from it.
struct VolumeStamp {
  std::uint64_t volume_id = 0;            ///< counts the volumes published by a ring, from 1
  std::uint64_t source_volume_index = 0;  ///< the source's own number of the sweep
  std::uint64_t first_frame_sequence = 0;
  std::uint64_t last_frame_sequence = 0;
  /// FrameStamp::number_in_recording() of these two frames: in a backward pass the first one is greater.
  std::uint64_t first_recorded_number = 0;
  std::uint64_t last_recorded_number = 0;
  std::uint32_t frames = 0;
  std::uint32_t frames_missing =
      0;                   ///< lost between others; the renderer interpolates between their neighbours
  SweepWarnings warnings;  ///< what looks wrong in the frames
  double angle_correction_rad =
      0;  ///< added to every measured angle: half the mismatch of forward and backward sweeps
  SweepDirection direction = SweepDirection::kForward;
  std::int64_t first_capture_time_ns = 0;
  std::int64_t last_capture_time_ns = 0;
};

/// One sweep: up to `frame_capacity` frames of a fan geometry in one block of memory, in order of arrival.
/// Volumes of one source may have different geometries; all frames of a volume have the same. The constructor
/// allocates all memory; filling and reading allocate nothing. Not thread safe: the ring ensures that one
/// thread at a time uses a volume.
class Volume {
 public:
  /// Capacity: `frame_capacity` frames of this geometry, or of others with at most `largest_frame_bytes` (0:
  /// as this geometry).
  Volume(const FanGeometry& geometry, std::uint32_t frame_capacity, std::uint64_t largest_frame_bytes = 0)
      : geometry_(geometry),
        frame_capacity_(frame_capacity),
        capacity_bytes_(std::max(geometry.frame_bytes(), largest_frame_bytes) * frame_capacity),
        // Not make_unique: it would write every page before the first sweep.
        pixels_(new std::uint8_t[capacity_bytes_]),
        angles_rad_(frame_capacity),
        commit_numbers_(frame_capacity),
        by_angle_(frame_capacity) {}

  const FanGeometry& geometry() const { return geometry_; }
  std::uint32_t frame_capacity() const { return frame_capacity_; }
  const VolumeStamp& stamp() const { return stamp_; }
  VolumeStamp& stamp() { return stamp_; }

  void clear() { stamp_ = {}; }

  /// Whether frame_capacity() frames of this geometry fit.
  bool holds(const FanGeometry& geometry) const {
    return geometry.frame_bytes() * frame_capacity_ <= capacity_bytes_;
  }
  /// Sets the geometry of the frames to come. Precondition: the volume has no frames, and holds(geometry).
  void set_geometry(const FanGeometry& geometry) { geometry_ = geometry; }

  bool full() const { return stamp_.frames == frame_capacity_; }

  /// Writes to all of its memory, which is in use then.
  void use_pages() { std::fill_n(pixels_.get(), capacity_bytes_, std::uint8_t{0}); }

  /// Becomes a copy of another volume. False where its frames do not fit; this volume stays as it is then.
  bool copy_from(const Volume& other);

  /// Memory for the next frame's pixels: rows x columns bytes, row major. Precondition: not full().
  std::span<std::uint8_t> next_frame_pixels() {
    return {pixels_.get() + geometry_.frame_bytes() * stamp_.frames, geometry_.frame_bytes()};
  }

  /// Adds the frame that was written to next_frame_pixels(). The order of arrival may differ from the order
  /// of capture.
  void add_frame(const FrameStamp& frame) {
    if (stamp_.frames == 0) {
      stamp_.source_volume_index = frame.volume_index;
      stamp_.direction = frame.direction;
      stamp_.first_capture_time_ns = frame.capture_time_ns;
    }
    if (stamp_.frames == 0 || frame.sequence < stamp_.first_frame_sequence) {
      stamp_.first_frame_sequence = frame.sequence;
      stamp_.first_recorded_number = frame.number_in_recording();
    }
    if (stamp_.frames == 0 || frame.sequence > stamp_.last_frame_sequence) set_last_number(frame);
    stamp_.first_capture_time_ns = std::min(stamp_.first_capture_time_ns, frame.capture_time_ns);
    stamp_.last_capture_time_ns = std::max(stamp_.last_capture_time_ns, frame.capture_time_ns);
    angles_rad_[stamp_.frames] = frame.angle_rad;
    commit_numbers_[stamp_.frames] = frame.commit_number;
    ++stamp_.frames;
  }

  /// Removes all frames after the first `frames`. `last` is the stamp of the last remaining frame in order of
  /// capture.
  void keep_first(std::uint32_t frames, const FrameStamp& last) {
    stamp_.frames = frames;
    set_last_number(last);
    stamp_.last_capture_time_ns = last.capture_time_ns;
  }

  /// Removes the frame with this index; the last frame takes its place. The stamp's times and sequence
  /// numbers stay: see set_span().
  void remove_frame(std::uint32_t index) {
    const std::uint32_t last = --stamp_.frames;
    if (index == last) return;
    std::ranges::copy(frame_pixels(last), pixels_.get() + geometry_.frame_bytes() * index);
    angles_rad_[index] = angles_rad_[last];
    commit_numbers_[index] = commit_numbers_[last];
  }

  /// Sets the stamp's times and sequence numbers: those of its first and last frame in order of capture.
  void set_span(const FrameStamp& first, const FrameStamp& last) {
    stamp_.first_frame_sequence = first.sequence;
    stamp_.first_recorded_number = first.number_in_recording();
    stamp_.first_capture_time_ns = first.capture_time_ns;
    set_last_number(last);
    stamp_.last_capture_time_ns = last.capture_time_ns;
  }

  /// Adds a correction to every angle and to the stamp's correction. Does not change the order.
  void turn_by(double correction_rad) {
    for (double& angle_rad : std::span(angles_rad_).first(stamp_.frames)) angle_rad += correction_rad;
    stamp_.angle_correction_rad += correction_rad;
  }

  /// Sorts by angle; call once, after the last frame. The renderer reads by_angle(), so a backward or
  /// unsteady sweep is read like a forward one.
  void sort_by_angle() {
    const auto order = std::span(by_angle_).first(stamp_.frames);
    std::iota(order.begin(), order.end(), std::uint32_t{0});
    // Equal angles are ordered by arrival: the order is total without std::stable_sort, which allocates.
    std::sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
      return angles_rad_[a] != angles_rad_[b] ? angles_rad_[a] < angles_rad_[b] : a < b;
    });
  }

  /// Frame indices (order of arrival) in ascending order of their angles.
  std::span<const std::uint32_t> by_angle() const { return std::span(by_angle_).first(stamp_.frames); }

  /// Motor angle of each frame, in order of arrival.
  std::span<const double> angles_rad() const { return std::span(angles_rad_).first(stamp_.frames); }

  /// FrameStamp::commit_number of each frame, in order of arrival: shows which of them a FrameQueue has
  /// already delivered.
  std::span<const std::uint64_t> commit_numbers() const {
    return std::span(commit_numbers_).first(stamp_.frames);
  }

  /// Pixels of frame `index` (order of arrival): rows x columns bytes, row major, row 0 nearest the probe.
  std::span<const std::uint8_t> frame_pixels(std::uint32_t index) const {
    return {pixels_.get() + geometry_.frame_bytes() * index, geometry_.frame_bytes()};
  }

  std::uint64_t capacity_bytes() const { return capacity_bytes_; }

 private:
  void set_last_number(const FrameStamp& last) {
    stamp_.last_frame_sequence = last.sequence;
    stamp_.last_recorded_number = last.number_in_recording();
  }

  FanGeometry geometry_;
  std::uint32_t frame_capacity_;
  std::uint64_t capacity_bytes_;
  std::unique_ptr<std::uint8_t[]> pixels_;
  std::vector<double> angles_rad_;
  std::vector<std::uint64_t> commit_numbers_;
  std::vector<std::uint32_t> by_angle_;
  VolumeStamp stamp_;
};

}  // namespace fanlight
