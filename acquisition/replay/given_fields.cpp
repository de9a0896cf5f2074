// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/given_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

template <typename T>
bool none_has(const FrameSequence& sequence, std::optional<T> SequenceFrame::*field) {
  return std::ranges::none_of(sequence.frames,
                              [field](const SequenceFrame& frame) { return (frame.*field).has_value(); });
}

Result<void> fill_times(const std::filesystem::path& path, const RecordingGeometry& geometry,
                        FrameSequence& sequence) {
  if (!geometry.frames_per_second || !none_has(sequence, &SequenceFrame::timestamp_s)) return {};
  constexpr double kLeastHz = 0.01;
  constexpr double kMostHz = 100'000;
  const double rate_hz = *geometry.frames_per_second;
  if (!(rate_hz >= kLeastHz && rate_hz <= kMostHz)) {
    return bad_file(path, fmt::format("frames_per_second is {}", rate_hz),
                    fmt::format("{} to {}", kLeastHz, kMostHz));
  }
  for (std::size_t i = 0; i < sequence.frames.size(); ++i)
    sequence.frames[i].timestamp_s = static_cast<double>(i) / rate_hz;
  return {};
}

Result<void> fill_sweeps(const std::filesystem::path& path, const RecordingGeometry& geometry,
                         FrameSequence& sequence) {
  if (!geometry.frames_per_sweep || !none_has(sequence, &SequenceFrame::volume_index)) return {};
  const double frames = *geometry.frames_per_sweep;
  if (!(frames >= 2 && frames <= 1e6 && frames == std::floor(frames)))
    return bad_file(path, fmt::format("frames_per_sweep is {}", frames), "a whole number from 2 on");
  const auto in_sweep = static_cast<std::size_t>(frames);
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    SequenceFrame& frame = sequence.frames[i];
    frame.volume_index = i / in_sweep;
    if (geometry.to_and_fro && i / in_sweep % 2 == 1) frame.direction = SweepDirection::kBackward;
  }
  return {};
}

/// Frames of one sweep, in order of time.
struct SweepOfFrames {
  std::size_t first = 0;
  std::size_t frames = 0;
  bool backward = false;
};

std::vector<SweepOfFrames> sweeps_of(const FrameSequence& sequence) {
  std::vector<SweepOfFrames> sweeps;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const SequenceFrame& frame = sequence.frames[i];
    if (i == 0 || frame.volume_index != sequence.frames[i - 1].volume_index)
      sweeps.push_back({.first = i, .backward = frame.direction == SweepDirection::kBackward});
    ++sweeps.back().frames;
  }
  return sweeps;
}

/// Angles of a sweep's frames in the order of a forward sweep.
Result<std::vector<double>> forward_angles(const std::filesystem::path& path,
                                           const RecordingGeometry& geometry, std::size_t frames) {
  if (!geometry.angles_deg.empty()) {
    if (geometry.angles_deg.size() == frames) return geometry.angles_deg;
    return bad_file(
        path,
        fmt::format("angles_deg has {} numbers, and a sweep {} frames", geometry.angles_deg.size(), frames),
        "one number for each frame of the recording, or of every sweep");
  }
  if (!geometry.first_angle_deg || !geometry.last_angle_deg) {
    return bad_file(path, "sweep_starts_deg gives no angles within a sweep",
                    "also angles_deg, or first_angle_deg and last_angle_deg");
  }
  std::vector<double> angles_deg(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const double share = frames == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(frames - 1);
    angles_deg[i] = std::lerp(*geometry.first_angle_deg, *geometry.last_angle_deg, share);
  }
  return angles_deg;
}

}  // namespace

Result<bool> fill_from_geometry(const std::filesystem::path& path, const RecordingGeometry& geometry,
                                FrameSequence& sequence) {
  if (auto filled = fill_times(path, geometry, sequence); !filled) return filled.error();
  if (auto filled = fill_sweeps(path, geometry, sequence); !filled) return filled.error();
  const std::vector<double>& starts_deg = geometry.sweep_starts_deg;
  if ((geometry.angles_deg.empty() && starts_deg.empty()) ||
      !none_has(sequence, &SequenceFrame::motor_angle_deg))
    return false;
  const auto sweeps = sweeps_of(sequence);
  if (!starts_deg.empty() && starts_deg.size() != sweeps.size()) {
    return bad_file(path,
                    fmt::format("sweep_starts_deg has {} numbers, and the recording {} sweeps",
                                starts_deg.size(), sweeps.size()),
                    "one for each");
  }
  if (starts_deg.empty() && geometry.angles_deg.size() == sequence.frames.size()) {
    for (std::size_t i = 0; i < sequence.frames.size(); ++i)
      sequence.frames[i].motor_angle_deg = geometry.angles_deg[i];
    return true;
  }
  for (std::size_t k = 0; k < sweeps.size(); ++k) {
    const SweepOfFrames& sweep = sweeps[k];
    auto angles_deg = forward_angles(path, geometry, sweep.frames);
    if (!angles_deg) return angles_deg.error();
    if (sweep.backward) std::ranges::reverse(*angles_deg);
    const double shift_deg = starts_deg.empty() ? 0 : starts_deg[k] - angles_deg->front();
    for (std::size_t i = 0; i < sweep.frames; ++i)
      sequence.frames[sweep.first + i].motor_angle_deg = (*angles_deg)[i] + shift_deg;
  }
  return true;
}

}  // namespace fanlight
