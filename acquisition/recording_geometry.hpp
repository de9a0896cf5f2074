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
///      `key = number` in TOML
///   2. fields of the recording's own header (FanlightMotorRadiusMm for motor_radius_mm, and so on)
///   3. pixel_width_mm and pixel_height_mm: its ImageToReferenceTransform
/// Required keys: pixel_width_mm, pixel_height_mm, face_column, face_row, motor_radius_mm. Optional:
/// probe_radius_mm, sector_half_angle_deg, sector_reach_mm (FanGeometry::Sector), and first_angle_deg,
/// last_angle_deg, over which the frames of a recording without motor angles are spread.
struct RecordingGeometry {
  /// One value and where it came from, for a person.
  struct Value {
    std::string_view key;
    double value = 0;
    std::string origin;  ///< "liver.toml", "the header", ...
  };

  FanGeometry geometry;
  std::optional<double> first_angle_deg;
  std::optional<double> last_angle_deg;
  std::vector<Value> values;
};

/// `geometry_path` may be empty. kBadInput names the keys that are missing and where they may come from.
Result<RecordingGeometry> find_geometry(const std::filesystem::path& recording_path,
                                        const IgsSequence& sequence,
                                        const std::filesystem::path& geometry_path);

}  // namespace fanlight
