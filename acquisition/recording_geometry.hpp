#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/igs_sequence.hpp"
#include "proto/fan_geometry.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// How the frames of a recording lie in space, and who said so.
///
/// Each value is taken from the first of these that has it:
///   1. a geometry file named by the user, or else FILE.toml beside the recording FILE: lines of
///      `key = value` in TOML
///   2. fields of the recording's own header (FanlightMotorRadiusMm for motor_radius_mm, and so on)
///   3. frame_kind: "cartesian"; pixel_width_mm and pixel_height_mm: its ImageToReferenceTransform, except
///      for convex lines
/// Columns and rows are those of the frames as read, whatever the orientation of the file (IgsSequence).
///
/// Required keys: pixel_height_mm, face_column, face_row, motor_radius_mm; where columns are parallel
/// ("cartesian", "linear-lines") pixel_width_mm, for "convex-lines" probe_radius_mm and line_pitch_deg.
/// Optional: for Cartesian frames probe_radius_mm, sector_half_angle_deg, sector_reach_mm
/// (FanGeometry::Sector); first_angle_deg, last_angle_deg, over which the frames of a recording without motor
/// angles are spread. A value that a kind of frame does not have is not read, but a line_pitch_deg
/// contradicts all kinds but its own.
struct RecordingGeometry {
  /// One value and where it came from, for a person.
  struct Value {
    std::string_view key;
    std::string value;   ///< a number, or the name of a choice
    std::string origin;  ///< "liver.toml", "the header", ...
  };

  FanGeometry geometry;
  std::optional<double> first_angle_deg;
  std::optional<double> last_angle_deg;
  std::vector<Value> values;
};

/// `geometry_path` may be empty. kBadInput names the keys that are missing and where they may come from, or
/// the value that is wrong.
Result<RecordingGeometry> find_geometry(const std::filesystem::path& recording_path,
                                        const IgsSequence& sequence,
                                        const std::filesystem::path& geometry_path);

}  // namespace fanlight
