// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "acquisition/sequence/frame_sequence.hpp"
#include "acquisition/sequence/recording_geometry.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// Fills the fields that frames lack with what the geometry gives: times by frames_per_second, sweeps by
/// frames_per_sweep and sweep_order, angles by angles_deg and sweep_starts_deg. Whether it gave angles.
/// Fields that frames have are kept. kBadInput: a list does not fit the frames.
Result<bool> fill_from_geometry(const std::filesystem::path& path, const RecordingGeometry& geometry,
                                FrameSequence& sequence);

}  // namespace fanlight
