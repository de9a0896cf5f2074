// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "acquisition/sequence/sector_guess.hpp"
#include "proto/base/result.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

/// The geometry of Cartesian frames with the sector that is seen in them. nullopt where it does not fit the
/// geometry: the face of the probe, and its radius where that is not 0.
std::optional<FanGeometry> with_sector(const FanGeometry& geometry, const SectorGuess& seen);

/// Looks for the sector of a recording that has none in its geometry, in up to 64 of its frames. nullopt: the
/// frames are no images, fill their rectangle, or show no sector that fits. Errors as of
/// open_recording_file().
Result<std::optional<FanGeometry>> see_sector(const std::filesystem::path& path, std::uint64_t max_bytes,
                                              const FanGeometry& geometry);

/// A sentence for the user.
std::string note_on_seen_sector(const FanGeometry& geometry);

}  // namespace fanlight
