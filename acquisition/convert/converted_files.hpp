// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "acquisition/convert/grid_volume.hpp"
#include "acquisition/replay/replay_source.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

// Each writes a file whole or not at all, and never in place of another: kInvalidArgument where the name is
// taken, kUnavailable where the disk refuses. Axes: the transducer frame has no place in the patient; its x,
// y, z are written as the left, posterior and superior axis, which keeps it right-handed, in mm.

/// As NRRD: 8 bit, raw.
Result<void> write_grid_nrrd(const std::filesystem::path& path, const GridVolume& grid);

/// As NIfTI-1 in one file (.nii, or .nii.gz compressed): 8 bit, with an sform (RAS, so x and y are negated).
/// Source: nifti1.h of the NIfTI Data Format Working Group.
Result<void> write_grid_nifti(const std::filesystem::path& path, const GridVolume& grid);

/// All frames of a recording as a NRRD sequence (.seq.nrrd), raw, with the fields of a PLUS sequence for each
/// frame: what a replay of it gives is the same. Errors also as of ReplaySource.
Result<void> write_sequence_nrrd(const std::filesystem::path& path, const Recording::Config& recording,
                                 const Progress& progress);

}  // namespace fanlight
