// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// The bytes of a file of measurements; nullopt: there is none. Follows no symbolic link, since the folder
/// may be anybody's. Errors, kUnavailable: it is no regular file of at most 20 MB, or cannot be read.
Result<std::optional<std::string>> read_measurement_file(const std::filesystem::path& path);

/// What could be read of such a file.
struct ReadMeasurements {
  v1::MeasurementFile file;
  /// Why entries, or all, could not be read, a sentence each for the log. They hold text of the file.
  std::vector<std::string> troubles;
};
/// Reads the entries one by one: one that is damaged, or of a later version, costs no other.
ReadMeasurements parse_measurements(std::string_view text);

/// The text of such a file: protobuf's JSON with the names of the schema, one value a line. Takes up to 0.2
/// s.
std::string measurement_file_text(const v1::MeasurementFile& file);

}  // namespace fanlight
