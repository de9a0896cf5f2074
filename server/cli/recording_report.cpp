// SPDX-License-Identifier: Apache-2.0
#include "server/cli/recording_report.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <vector>

#include "proto/base/printable.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

/// "a convex probe: scan lines over 70 deg, the face 40 mm from their apex; 160 mm deep"
std::string geometry_words(const FanGeometry& geometry) {
  std::string words;
  switch (geometry.kind) {
    case FrameKind::kCartesian:
      words = fmt::format("images of {:.4g} x {:.4g} mm", geometry.columns * geometry.pixel_width_mm,
                          geometry.rows * geometry.pixel_height_mm);
      if (geometry.sector.half_angle_deg > 0)
        words += fmt::format(", a sector of {:.4g} deg in them", 2 * geometry.sector.half_angle_deg);
      break;
    case FrameKind::kConvexLines:
      words = fmt::format("{} scan lines of a curved array, over {:.4g} deg", geometry.columns,
                          (geometry.columns - 1) * geometry.line_pitch_deg);
      break;
    case FrameKind::kLinearLines:
      words = fmt::format("{} parallel scan lines of a flat array, over {:.4g} mm", geometry.columns,
                          (geometry.columns - 1) * geometry.pixel_width_mm);
      break;
  }
  if (geometry.probe_radius_mm > 0)
    words += fmt::format(", the face {:.4g} mm from their apex", geometry.probe_radius_mm);
  return fmt::format("{}; {:.4g} mm deep; swept about an axis {:.4g} mm behind the face", words,
                     geometry.depth_mm(), geometry.motor_radius_mm);
}

/// Rounded to what it is worth; never -0.
double to_step(double value, double step) {
  return std::round(value / step) / std::round(1 / step) + 0.0;
}

}  // namespace

std::string angle_plot(const Recording& recording, int columns, int rows) {
  const RecordingSummary& summary = recording.summary();
  const double least_deg = summary.smallest_angle_deg;
  const double range_deg = summary.largest_angle_deg - least_deg;
  const auto end_ns = static_cast<double>(recording.frames().back().time_ns);
  std::vector<std::string> lines(static_cast<std::size_t>(rows),
                                 std::string(static_cast<std::size_t>(columns), ' '));
  for (const Recording::Frame& frame : recording.frames()) {
    const double up = (degrees(frame.angle_rad) - least_deg) / range_deg;
    if (!frame.valid || up < 0 || up > 1) continue;
    const auto row = static_cast<std::size_t>(std::lround((1 - up) * (rows - 1)));
    const auto column =
        static_cast<std::size_t>(std::lround(static_cast<double>(frame.time_ns) / end_ns * (columns - 1)));
    lines[row][column] = '*';
  }
  std::string text;
  for (int row = 0; row < rows; ++row) {
    const bool labelled = row == 0 || row == rows - 1;
    const std::string label =
        labelled ? fmt::format("{:.1f} deg", row == 0 ? summary.largest_angle_deg : least_deg) : "";
    std::string& line = lines[static_cast<std::size_t>(row)];
    line.erase(line.find_last_not_of(' ') + 1);
    text += fmt::format("  {:>11} |{}\n", label, line);
  }
  return text +
         fmt::format("  {:>11} 0 s{:>{}}\n", "", fmt::format("{:.1f} s", summary.duration_s), columns - 2);
}

std::string recording_text(const Recording& recording) {
  const RecordingSummary& summary = recording.summary();
  std::string text = fmt::format("{}\n", summary.name);
  const auto add = [&text]<typename... T>(fmt::format_string<T...> format, T&&... values) {
    text += fmt::format(format, std::forward<T>(values)...);
  };
  add("  frames      {} of {} x {}, {}{}\n", summary.frames, summary.columns, summary.rows,
      summary.format.name(), summary.compressed ? ", compressed" : "");
  add("  invalid     {}, of them {} by their angle; lost while recording {}\n", summary.frames_invalid,
      summary.angle_outliers, summary.frames_lost);
  add("  sweeps      {}, the longest of {} frames\n", summary.sweeps, summary.frames_in_longest_sweep);
  add("  angles      {:.2f} to {:.2f} deg\n", to_step(summary.smallest_angle_deg, 0.01),
      to_step(summary.largest_angle_deg, 0.01));
  add("  time        {:.2f} s, {:.1f} frames a second\n", summary.duration_s, summary.frame_rate_hz);
  if (const RecordedStream* const stream = recording.stream()) {
    add("  recorded    {:%Y-%m-%d %H:%M:%S} UTC from {}\n",
        fmt::gmtime(static_cast<std::time_t>(stream->facts.begun_utc_s)), printable(stream->facts.source));
  }
  add("  geometry    {}\n", geometry_words(summary.geometry));
  for (const RecordingGeometry::Value& value : summary.geometry_values)
    add("  {:<23} {} (from {})\n", value.key, value.value, value.origin);
  text += angle_plot(recording, 60, 9);
  for (const std::string& note : summary.notes) add("  note: {}\n", note);
  return text;
}

nlohmann::ordered_json recording_json(const Recording& recording) {
  const RecordingSummary& summary = recording.summary();
  nlohmann::ordered_json report = {{"file", summary.name},
                                   {"can_be_played", true},
                                   {"frames", summary.frames},
                                   {"frames_invalid", summary.frames_invalid},
                                   {"frames_lost", summary.frames_lost},
                                   {"columns", summary.columns},
                                   {"rows", summary.rows},
                                   {"pixels", summary.format.name()},
                                   {"compressed", summary.compressed},
                                   {"sweeps", summary.sweeps},
                                   {"frames_in_longest_sweep", summary.frames_in_longest_sweep},
                                   {"smallest_angle_deg", summary.smallest_angle_deg},
                                   {"largest_angle_deg", summary.largest_angle_deg},
                                   {"duration_s", summary.duration_s},
                                   {"frame_rate_hz", summary.frame_rate_hz},
                                   {"geometry_words", geometry_words(summary.geometry)}};
  if (!summary.format.is_grey()) {
    report["window_black"] = summary.window.black;
    report["window_white"] = summary.window.white;
  }
  if (const RecordedStream* const stream = recording.stream()) {
    report["recorded_from"] = printable(stream->facts.source);
    report["recorded_utc_s"] = stream->facts.begun_utc_s;
  }
  auto& geometry = report["geometry"] = nlohmann::ordered_json::object();
  for (const RecordingGeometry::Value& value : summary.geometry_values)
    geometry[std::string(value.key)] = {{"value", value.value}, {"from", value.origin}};
  report["notes"] = summary.notes;
  return report;
}

std::string facts_text(const FileFacts& facts, const std::string& name) {
  std::string text = fmt::format("{}\n", name);
  text += fmt::format("  frames      {} of {} x {}, {}{}{}\n", facts.frames, facts.columns, facts.rows,
                      facts.format.name(), facts.compressed ? ", compressed" : "",
                      facts.scan_lines ? ", scan lines" : "");
  const auto some = [&](std::string_view what, std::uint32_t count) {
    const std::string how_many = count == 0 ? "none"
                                 : count == facts.frames
                                     ? "each frame"
                                     : fmt::format("{} of {} frames", count, facts.frames);
    text += fmt::format("  {:<11} {}\n", what, how_many);
  };
  some("times", facts.with_time);
  some("angles", facts.with_angle);
  some("volumes", facts.with_volume);
  some("poses", facts.with_pose);
  if (facts.pixel_size) {
    text += fmt::format("  pixels      {:.4g} x {:.4g} mm\n", facts.pixel_size->width_mm,
                        facts.pixel_size->height_mm);
  }
  if (facts.fit) {
    text += fmt::format(
        "  fan         by the poses: {:.1f} deg about an axis {:.0f} mm behind {}, which they miss by {:.1f} "
        "mm\n",
        degrees(std::ranges::max(facts.fit->angles_rad) - std::ranges::min(facts.fit->angles_rad)),
        axis_behind_face_mm(facts), facts.sector ? "the probe's face" : "row 0", facts.fit->residual_mm);
  }
  if (const auto& sector = facts.sector; sector && sector->diverges) {
    text += fmt::format(
        "  seen        a sector of {:.0f} deg; its edges meet at column {:.0f}, row {:.0f}; the face is "
        "at row {:.0f}\n",
        2 * sector->half_angle_deg, sector->face_column, sector->apex_row, sector->face_row);
  } else if (sector) {
    text += fmt::format("  seen        a rectangle from column {:.0f} to {:.0f}, rows {:.0f} to {:.0f}\n",
                        sector->left_column, sector->right_column, sector->face_row, sector->last_row);
  }
  return text;
}

nlohmann::ordered_json facts_json(const FileFacts& facts, const std::string& name, const std::string& why) {
  nlohmann::ordered_json report = {{"file", name},
                                   {"can_be_played", false},
                                   {"why", why},
                                   {"frames", facts.frames},
                                   {"columns", facts.columns},
                                   {"rows", facts.rows},
                                   {"pixels", facts.format.name()},
                                   {"compressed", facts.compressed},
                                   {"frames_with_time", facts.with_time},
                                   {"frames_with_angle", facts.with_angle},
                                   {"frames_with_volume", facts.with_volume},
                                   {"frames_with_pose", facts.with_pose}};
  if (facts.pixel_size) {
    report["pixel_width_mm"] = facts.pixel_size->width_mm;
    report["pixel_height_mm"] = facts.pixel_size->height_mm;
  }
  if (facts.fit) {
    report["axis_behind_row_0_mm"] = to_step(-facts.fit->axis_mm, 0.1);
    if (facts.sector) report["axis_behind_face_mm"] = to_step(axis_behind_face_mm(facts), 0.1);
    report["axis_misfit_mm"] = to_step(facts.fit->residual_mm, 0.1);
  }
  if (const auto& sector = facts.sector) {
    report["face_column"] = to_step(sector->face_column, 0.5);
    report["face_row"] = to_step(sector->face_row, 0.5);
    if (sector->diverges) {
      report["apex_row"] = to_step(sector->apex_row, 1);
      report["sector_half_angle_deg"] = to_step(sector->half_angle_deg, 0.5);
    }
  }
  report["geometry_draft"] = geometry_draft(facts, name);
  return report;
}

}  // namespace fanlight
