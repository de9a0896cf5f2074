// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/plus_fields.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <iterator>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

constexpr std::array<std::string_view, 5> kFaultNames = {"", "invalid", "damaged", "cut", "misfit"};

std::string geometry_lines(const FanGeometry& geometry) {
  std::string text =
      fmt::format("FanlightFrameKind = {}\n", kFrameKindNames[static_cast<std::size_t>(geometry.kind)]);
  const auto add = [&text](std::string_view name, double value) {
    fmt::format_to(std::back_inserter(text), "Fanlight{} = {}\n", name, value);
  };
  if (!geometry.polar()) add("PixelWidthMm", geometry.pixel_width_mm);
  add("PixelHeightMm", geometry.pixel_height_mm);
  if (geometry.polar()) add("LinePitchDeg", geometry.line_pitch_deg);
  add("FaceColumn", geometry.face_column);
  add("FaceRow", geometry.face_row);
  add("MotorRadiusMm", geometry.motor_radius_mm);
  if (geometry.kind != FrameKind::kLinearLines) add("ProbeRadiusMm", geometry.probe_radius_mm);
  if (geometry.kind == FrameKind::kCartesian && geometry.sector.half_angle_deg > 0) {
    add("SectorHalfAngleDeg", geometry.sector.half_angle_deg);
    add("SectorReachMm", geometry.sector.reach_mm);
  }
  // A replay shows what the source showed, and detects nothing more.
  if (geometry.kind == FrameKind::kCartesian)
    text += fmt::format("FanlightUnscanned = {}\n", geometry.zero_is_unscanned ? "zero" : "none");
  if (geometry.unknown_beams) text += "FanlightBeams = unknown\n";
  return text;
}

std::string facts_lines(const RecordingFacts& facts) {
  std::string text = fmt::format("FanlightSource = {}\n", facts.source);
  fmt::format_to(std::back_inserter(text), "FanlightBegun = {:%Y-%m-%dT%H:%M:%SZ}\n",
                 fmt::gmtime(static_cast<std::time_t>(facts.begun_utc_s)));
  fmt::format_to(std::back_inserter(text), "FanlightSweepsNumbered = {}\n",
                 facts.counts_volumes ? "True" : "False");
  fmt::format_to(std::back_inserter(text), "FanlightFramesPerVolume = {}\n", facts.frames_per_volume);
  fmt::format_to(std::back_inserter(text), "FanlightUsualFrames = {}\n", facts.usual_frames);
  fmt::format_to(std::back_inserter(text), "FanlightSmallestAngleRad = {}\n", facts.first_angle_rad);
  fmt::format_to(std::back_inserter(text), "FanlightLargestAngleRad = {}\n", facts.last_angle_rad);
  if (facts.simulated) text += "FanlightSimulated = True\n";
  return text;
}

/// Row order. Its columns: from column to column, from row to row, the unit normal, and pixel (0, 0), by
/// FanGeometry::point().
std::array<double, 16> image_to_transducer(const FanGeometry& geometry, double angle_rad) {
  const double cosine = std::cos(angle_rad);
  const double sine = std::sin(angle_rad);
  const double radius_mm = geometry.motor_radius_mm;
  const double first_mm = radius_mm - geometry.face_row * geometry.pixel_height_mm;
  return {geometry.pixel_width_mm,
          0,
          0,
          -geometry.face_column * geometry.pixel_width_mm,
          0,
          geometry.pixel_height_mm * cosine,
          -sine,
          first_mm * cosine - radius_mm,
          0,
          geometry.pixel_height_mm * sine,
          cosine,
          first_mm * sine,
          0,
          0,
          0,
          1};
}

/// What every kind of file says of a frame, by add(name, value).
template <typename Add>
void add_frame_fields(const RecordingFacts& facts, const RecordedFrame& frame, const Add& add) {
  const FrameStamp& stamp = frame.stamp;
  add("ImageStatus", frame.usable() ? "OK" : "INVALID");
  if (std::isfinite(stamp.angle_rad)) {
    add("MotorAngleDeg", degrees(stamp.angle_rad));
    add(plus_field::kMotorAngleRad, stamp.angle_rad);
  }
  add(plus_field::kFrameSequence, stamp.sequence);
  if (facts.counts_volumes) {
    add("VolumeIndex", stamp.volume_index);
    add("FrameIndex", stamp.frame_index);
    add("SweepDirection", stamp.direction == SweepDirection::kForward ? "FORWARD" : "BACKWARD");
    if (stamp.frames_in_sweep > 0) add(plus_field::kFramesInSweep, stamp.frames_in_sweep);
  }
  if (!frame.usable()) add(plus_field::kFrameFault, fault_name(frame.fault));
  if (stamp.after_interruption) add(plus_field::kAfterInterruption, 1);
}

/// "Name = value" lines.
PlusFields fields_of(std::string_view lines) {
  PlusFields fields;
  while (!lines.empty()) {
    const std::size_t end = lines.find('\n');
    const std::string_view line = lines.substr(0, end);
    const std::size_t equals = line.find(" = ");
    fields.emplace_back(line.substr(0, equals), line.substr(equals + 3));
    lines.remove_prefix(end + 1);
  }
  return fields;
}

}  // namespace

PlusFields fanlight_fields(const RecordingFacts& facts) {
  return fields_of(geometry_lines(facts.geometry) + facts_lines(facts));
}

PlusFields frame_fields(const RecordingFacts& facts, const RecordedFrame& frame) {
  PlusFields fields;
  add_frame_fields(facts, frame, [&fields](std::string_view name, const auto& value) {
    fields.emplace_back(name, fmt::format("{}", value));
  });
  return fields;
}

RecordingFacts facts_of(const SourceDescription& source) {
  return {.source = printable(source.name),
          .geometry = source.geometry,
          .counts_volumes = source.counts_volumes,
          .frames_per_volume = source.frames_per_volume,
          .usual_frames = source.usual_frames,
          .simulated = source.simulated,
          .first_angle_rad = source.first_angle_rad,
          .last_angle_rad = source.last_angle_rad};
}

std::string_view fault_name(FrameFault fault) {
  return kFaultNames[static_cast<std::size_t>(fault)];
}

std::optional<FrameFault> fault_named(std::string_view name) {
  const auto found = std::find(kFaultNames.begin() + 1, kFaultNames.end(), name);
  if (found == kFaultNames.end()) return std::nullopt;
  return static_cast<FrameFault>(found - kFaultNames.begin());
}

std::string plus_header(const RecordingFacts& facts, const PlusHeader& header) {
  std::string text =
      "ObjectType = Image\n"
      "NDims = 3\n"
      "AnatomicalOrientation = RAI\n"
      "BinaryData = True\n"
      "BinaryDataByteOrderMSB = False\n"
      "CenterOfRotation = 0 0 0\n";
  fmt::format_to(std::back_inserter(text), "CompressedData = {}\n",
                 header.compressed_bytes ? "True" : "False");
  if (header.compressed_bytes)
    fmt::format_to(std::back_inserter(text), "CompressedDataSize = {:<20}\n", *header.compressed_bytes);
  fmt::format_to(std::back_inserter(text), "DimSize = {} {} {}\n", facts.geometry.columns,
                 facts.geometry.rows, header.frames);
  text +=
      "ElementNumberOfChannels = 1\n"
      "ElementSpacing = 1 1 1\n"
      "ElementType = MET_UCHAR\n"
      "Kinds = domain domain list\n"
      "Offset = 0 0 0\n"
      "TransformMatrix = 1 0 0 0 1 0 0 0 1\n"
      "UltrasoundImageOrientation = MF\n"
      "UltrasoundImageType = BRIGHTNESS\n";
  return text + geometry_lines(facts.geometry) + facts_lines(facts);
}

double add_plus_frame(std::string& text, std::uint64_t index, const RecordingFacts& facts,
                      const RecordedFrame& frame, std::int64_t first_time_ns, double last_time_s) {
  const FrameStamp& stamp = frame.stamp;
  const std::string prefix = fmt::format("Seq_Frame{:04}_", index);
  const auto add = [&](std::string_view name, const auto& value) {
    fmt::format_to(std::back_inserter(text), "{}{} = {}\n", prefix, name, value);
  };
  const double time_s =
      std::max(last_time_s, static_cast<double>(stamp.capture_time_ns - first_time_ns) * 1e-9);
  const std::string time = fmt::format("{:.9f}", time_s);
  add("FrameNumber", index);
  add("UnfilteredTimestamp", time);
  add("Timestamp", time);
  if (!facts.geometry.polar() && std::isfinite(stamp.angle_rad)) {
    add("ImageToReferenceTransform",
        fmt::format("{}", fmt::join(image_to_transducer(facts.geometry, stamp.angle_rad), " ")));
    add("ImageToReferenceTransformStatus", "OK");
  }
  add_frame_fields(facts, frame, add);
  return time_s;
}

std::string plus_data_line(std::string_view file) {
  return fmt::format("ElementDataFile = {}\n", file);
}

}  // namespace fanlight
