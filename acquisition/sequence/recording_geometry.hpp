// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/sequence/frame_sequence.hpp"
#include "acquisition/sequence/unscanned.hpp"
#include "proto/base/result.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

/// Geometry of the frames of a recording, and the origin of each value.
///
/// Each value is taken from the first of these that contains it:
///   1. a geometry file given by the user: lines of `key = value` in TOML
///   2. fields of the recording's own header (FanlightMotorRadiusMm for motor_radius_mm, and so on)
///   3. pixel_width_mm and pixel_height_mm: its ImageToReferenceTransform or calibrated region, except for
///      convex lines
///   4. without a file given, FILE.toml next to the recording FILE
///   5. frame_kind: "cartesian"
/// Where the file and the recording give different values, `contradictions` says so. A transform with pixels
/// of exactly 1 x 1 mm is taken for one that was never set: it comes last.
///
/// Columns and rows are those of the frames after reading, whatever the orientation of the file
/// (FrameSequence).
///
/// Required keys: pixel_height_mm, face_column, face_row, motor_radius_mm; where columns are parallel
/// ("cartesian", "linear-lines") pixel_width_mm; for "convex-lines" probe_radius_mm and line_pitch_deg.
/// Optional: for Cartesian frames probe_radius_mm, sector_half_angle_deg, sector_reach_mm
/// (FanGeometry::Sector); first_angle_deg and last_angle_deg, the range over which the frames of a recording
/// without motor angles are spread; angles_deg, a list with the angle of each frame, or of the frames of one
/// sweep; sweep_starts_deg, a list with the first angle of each sweep, where the motor begins elsewhere each
/// time; frames_per_second, for frames without times; frames_per_sweep, for frames without VolumeIndex, with
/// sweep_order "one-way" or "to-and-fro"; unscanned, by the names of Unscanned; beams, "swept" or "unknown"
/// (FanGeometry::unknown_beams); window_black and window_white, the values of pixels of 16 bit, or of signed
/// ones, that are shown black and white; columns, rows and frames, where the geometry is for frames of one
/// size or number only. A value that a kind of frame
/// does not have is ignored; but line_pitch_deg is refused for every kind except "convex-lines".
struct RecordingGeometry {
  /// One value and its origin, for display.
  struct Value {
    std::string_view key;
    std::string value;   ///< a number, or the name of a choice
    std::string origin;  ///< "liver.toml", "the header", ...
  };

  FanGeometry geometry;
  std::optional<double> for_columns;  ///< size and number of the frames that the geometry is for
  std::optional<double> for_rows;
  std::optional<double> for_frames;
  std::optional<double> first_angle_deg;
  std::optional<double> last_angle_deg;
  std::optional<double> frames_per_second;
  std::optional<double> frames_per_sweep;
  bool to_and_fro = false;  ///< every second sweep is backward
  Unscanned unscanned = Unscanned::kDetect;
  std::vector<double> angles_deg;  ///< of the frames of the recording, or of each sweep; empty: not given
  std::vector<double> sweep_starts_deg;  ///< of each sweep; empty: not given
  std::optional<double> window_black;    ///< both or none: see ValueWindow
  std::optional<double> window_white;
  std::optional<FanFit> fit;  ///< of tracked poses, from which the motor angles are
  std::vector<Value> values;
  std::vector<std::string> contradictions;  ///< a sentence for each value that two origins give differently
  std::vector<std::string> suspicions;      ///< a sentence for each angle that looks like radians
};

/// FILE.toml next to a recording FILE.
std::filesystem::path sidecar(std::filesystem::path recording_path);

/// `geometry_path` may be empty. `fit`: gives the motor radius where nothing else does. kBadInput names the
/// missing keys and where they may be given, or the wrong value.
Result<RecordingGeometry> find_geometry(const std::filesystem::path& recording_path,
                                        const FrameSequence& sequence,
                                        const std::filesystem::path& geometry_path,
                                        const std::optional<FanFit>& fit = {});

}  // namespace fanlight
