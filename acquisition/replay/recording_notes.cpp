// SPDX-License-Identifier: Apache-2.0
// What a recording says of itself, for people.
#include <fmt/format.h>

#include "acquisition/replay/recording.hpp"

namespace fanlight {

namespace {

// A usual sweep has 20 to 90 deg; this is 2.6 rad, taken for degrees.
constexpr double kLeastFanDeg = 2.6;

}  // namespace

void Recording::add_notes(const RecordingGeometry& geometry) {
  std::vector<std::string>& notes = summary_.notes;
  notes = sequence_.notes;
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
    notes.push_back(
        fmt::format("{} of {} frames are left out: their angle lies apart from their neighbours'.",
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
