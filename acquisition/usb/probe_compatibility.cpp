// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/probe_compatibility.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fanlight {

namespace {

// Largest memory of one volume; the ring has several.
constexpr std::uint64_t kMostVolumeBytes = 1 << 30;

Result<void> check_setting(const char* name, double value, double least, double most, const char* unit) {
  if (value >= least && value <= most) return {};
  return Error{ErrorCode::kInvalidArgument, fmt::format("the probe's {} was to be {}{}, expected {} to {}{}",
                                                        name, value, unit, least, most, unit)};
}

}  // namespace

std::uint32_t volume_capacity(const probe::Capabilities& offered) {
  const std::uint64_t frame_bytes = std::uint64_t{offered.most_columns} * offered.most_rows;
  const std::uint32_t wanted =
      offered.counts_volumes ? offered.most_frames : offered.most_frames + offered.most_frames / 4 + 8;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, kMostVolumeBytes / frame_bytes));
}

Result<void> check_settings(const probe::Settings& settings, const probe::Capabilities& offered) {
  auto outcome =
      check_setting("sweep", settings.sweep_deg, offered.least_sweep_deg, offered.most_sweep_deg, " deg");
  if (outcome) {
    outcome = check_setting("number of frames a volume", settings.frames_a_volume, offered.least_frames,
                            offered.most_frames, "");
  }
  if (outcome) {
    outcome = check_setting("depth", settings.depth_mm, offered.least_depth_mm, offered.most_depth_mm, " mm");
  }
  return outcome;
}

Result<void> check_fit(const probe::Capabilities& offered, const probe::Settings& settings,
                       const FanGeometry& fan, const SourceDescription& made_for) {
  if (offered.counts_volumes == made_for.counts_volumes &&
      settings.frames_a_volume <= made_for.frames_per_volume &&
      fan.frame_bytes() <= made_for.largest_frame_bytes) {
    return {};
  }
  return Error{ErrorCode::kUnsupported,
               fmt::format("the connected probe sends {} frames a volume of {} bytes and {} its volumes; "
                           "expected at most {} of {} bytes and one that {}, or a restart of Fanlight",
                           settings.frames_a_volume, fan.frame_bytes(),
                           offered.counts_volumes ? "counts" : "does not count", made_for.frames_per_volume,
                           made_for.largest_frame_bytes, made_for.counts_volumes ? "does" : "does not")};
}

}  // namespace fanlight
