// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/frame_notes.hpp"

#include <string_view>

#include "acquisition/sequence/plus_fields.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

FrameNotes frame_notes(const igtl::Metadata& metadata) {
  FrameNotes notes;
  std::optional<double> angle_deg;
  metadata.for_each([&](std::string_view name, std::string_view value) {
    if (name == plus_field::kMotorAngleRad) notes.angle_rad = number_in<double>(value);
    if (name == "MotorAngleDeg") angle_deg = number_in<double>(value);
    if (name == plus_field::kFrameSequence) notes.sequence = number_in<std::uint64_t>(value);
    if (name == "VolumeIndex") notes.volume_index = number_in<std::uint64_t>(value);
    if (name == "FrameIndex") notes.frame_index = number_in<std::uint32_t>(value);
    if (name == plus_field::kFramesInSweep) notes.frames_in_sweep = number_in<std::uint32_t>(value);
    if (name == "SweepDirection" && value == "FORWARD") notes.direction = SweepDirection::kForward;
    if (name == "SweepDirection" && value == "BACKWARD") notes.direction = SweepDirection::kBackward;
    if (name == plus_field::kOrigin) notes.origin = frame_origin(value);
    if (name == plus_field::kAgeMs) notes.age_ms = number_in<std::uint32_t>(value);
    if (name == "ImageStatus") notes.is_invalid = value == "INVALID";
    if (name == plus_field::kAfterInterruption) notes.after_interruption = value == "1";
  });
  if (!notes.angle_rad && angle_deg) notes.angle_rad = radians(*angle_deg);
  return notes;
}

}  // namespace fanlight
