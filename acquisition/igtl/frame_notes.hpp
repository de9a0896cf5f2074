// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "proto/igtl/metadata.hpp"
#include "proto/model/frame.hpp"
#include "proto/model/frame_origin.hpp"

namespace fanlight {

/// What the metadata of an image says of it as a frame of a sweep: the fields that recordings have
/// (plus_field). Absent where it is not there, or no number.
struct FrameNotes {
  std::optional<double> angle_rad;  ///< MotorAngleRad, or MotorAngleDeg
  std::optional<std::uint64_t> sequence;
  std::optional<std::uint64_t> volume_index;
  std::optional<std::uint32_t> frame_index;
  std::optional<std::uint32_t> frames_in_sweep;
  std::optional<SweepDirection> direction;
  std::optional<FrameOrigin> origin;    ///< FrameOrigin
  std::optional<std::uint32_t> age_ms;  ///< FrameAgeMs: from the capture to the sending
  bool is_invalid = false;              ///< its ImageStatus is INVALID
  bool after_interruption = false;
};

/// Allocates nothing.
FrameNotes frame_notes(const igtl::Metadata& metadata);

}  // namespace fanlight
