// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "acquisition/replay/voxel_grid.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// Volumes of a NIfTI file.
struct NiftiVolumes {
  VoxelGrid grid;
  PixelFormat format;
  std::vector<std::uint8_t> voxels;  ///< stored values, the first axis fastest
  std::vector<std::string> notes;
};

/// Whether a file is NIfTI-1 in one file (.nii), plain or compressed by gzip: by its first 348 bytes, or, if
/// it is not empty, by its name.
bool is_nifti(const std::filesystem::path& path, std::span<const unsigned char> first_bytes);

/// Reads a NIfTI-1 file (https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h): three axes, or four with
/// time as the last, of whole numbers of 8 or 16 bit in either byte order. Spacing and handedness are from
/// the sform, else from the qform, else from pixdim alone. A file that Fanlight wrote keeps its place in the
/// transducer frame. kUnsupported: other types of values, axes at no right angles; kBadInput: a damaged or
/// cut off file, or one of over `max_bytes` of voxels. Our own reader: libniftiio says what is wrong on
/// stderr alone.
Result<NiftiVolumes> read_nifti(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace fanlight
