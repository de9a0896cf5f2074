// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/assembly/dropped_sweeps.hpp"
#include "acquisition/open_source.hpp"
#include "proto/base/result.hpp"
#include "proto/model/sweep_warnings.hpp"

namespace fanlight {

/// What the first sweeps of a recording show when they are assembled.
struct SweepReport {
  std::uint64_t volumes = 0;  ///< assembled
  bool whole = false;         ///< these are all sweeps of the recording
  bool too_large = false;     ///< none was assembled: a sweep alone is above the limit
  WarnedVolumes warned{};
  std::vector<DroppedSweep> dropped;
};

/// Assembles the sweeps of a recording, up to 256 MB of frames, and two sweeps
/// where none is larger. Errors of the source.
Result<SweepReport> examine_sweeps(const std::string& file, const SourceOptions& options);

/// Lines for people, with two spaces before each.
std::string sweep_text(const SweepReport& report);
/// Adds "volumes_examined", "all_examined", "dropped" and "warnings".
void add_sweeps(nlohmann::ordered_json& json, const SweepReport& report);

/// "warning: 3 of 28 volumes: Frames are ...", a line each. `before`: of each line.
std::string warnings_text(const WarnedVolumes& warned, std::uint64_t volumes, std::string_view before = "");
nlohmann::ordered_json warnings_json(const WarnedVolumes& warned);

}  // namespace fanlight
