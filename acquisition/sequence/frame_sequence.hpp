// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/sequence/fan_fit.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "proto/model/frame.hpp"

namespace fanlight {

/// Header fields of one frame; absent where the header has none.
struct SequenceFrame {
  std::optional<double> timestamp_s;
  std::optional<double> motor_angle_deg;
  std::optional<std::uint64_t> volume_index;
  std::optional<std::uint32_t> frame_index;
  std::optional<SweepDirection> direction;
  bool valid = true;              ///< its ImageStatus is not INVALID
  std::optional<ImagePose> pose;  ///< ImageToReferenceTransform, in the file's axis order

  // Of Fanlight's own recorder: see plus_fields.hpp and RecordedStream.
  std::optional<double> motor_angle_rad;
  std::optional<std::uint64_t> sequence;
  std::optional<std::uint32_t> frames_in_sweep;
  FrameFault fault = FrameFault::kNone;
  bool after_interruption = false;
};

/// A PLUS/IGSIO sequence file (.igs.mha, .mha; .mhd with the pixels in a separate file): a MetaImage whose
/// last axis is time, with fields Seq_Frame0000_Name for each frame, or a NRRD sequence (.seq.nrrd, .nrrd,
/// .nhdr) with the same fields. Supported: B-mode frames of 8 or 16 bit, scan converted or as scan lines, in
/// each orientation of ImageOrientation, plain or compressed with zlib. After reading, all have one axis
/// order: columns (or scan lines) ascend towards the marked side, rows (or samples) away from the probe.
/// Fields used: Timestamp (s), MotorAngleDeg, VolumeIndex, FrameIndex, ImageStatus, ImageToReferenceTransform
/// (mm), and Fanlight's own SweepDirection (FORWARD or BACKWARD).
struct FrameSequence {
  struct PixelSize {
    double width_mm;   ///< from column to column
    double height_mm;  ///< from row to row
  };

  /// How far a transform leads from the first frame's.
  struct Motion {
    std::array<double, 16> first{};  ///< matrix, row order
    double most_mm = 0;
    double most_deg = 0;
  };

  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  bool compressed = false;
  PixelFormat format;  ///< in the file; `pixels` are grey levels
  std::vector<SequenceFrame> frames;
  std::optional<PixelSize> pixel_size;
  std::string_view pixel_size_origin = "its ImageToReferenceTransform";  ///< of the first frame that has one
  bool is_grid = false;  ///< the frames are planes of a volume on a grid; `fanlight_fields` is their geometry
  std::map<std::string, std::string, std::less<>> fanlight_fields;  ///< header fields named Fanlight...
  /// Transforms of the image or the probe (ProbeToTrackerTransform, ...), by name.
  std::map<std::string, Motion, std::less<>> motions;
  std::vector<std::string> notes;          ///< what the reader assumed, a sentence each
  std::unique_ptr<std::uint8_t[]> pixels;  ///< frames x rows x columns

  std::uint64_t frame_bytes() const { return std::uint64_t{columns} * rows; }
  std::span<const std::uint8_t> frame_pixels(std::size_t frame) const {
    return {pixels.get() + frame_bytes() * frame, frame_bytes()};
  }
};

}  // namespace fanlight
