// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace fanlight {

/// What was measured on a recording: x.igs.mha -> x.igs.mha.measurements.json, beside it. `recording` may be
/// a folder.
inline std::filesystem::path measurements_path_of(const std::filesystem::path& recording) {
  const bool ends_with_slash = !recording.has_filename();
  return (ends_with_slash ? recording.parent_path() : recording).string() + ".measurements.json";
}

}  // namespace fanlight
