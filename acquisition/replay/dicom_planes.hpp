// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/replay/voxel_grid.hpp"
#include "acquisition/sequence/frame_sequence.hpp"
#include "proto/base/result.hpp"

class DcmItem;

namespace fanlight {

/// A plane of an Enhanced US Volume (DICOM PS3.3 C.8.24.3, C.8.24.6).
struct DicomPlane {
  std::uint32_t frame = 0;       ///< number in the file
  std::optional<double> time_s;  ///< Temporal Position Time Offset
  std::uint32_t volume = 0;      ///< counted from 0, by the times
  ImagePose pose{};              ///< from pixels (column, row, 0) to the volume's frame of reference, mm
};

/// The planes whose echoes are tissue, in the order of the volumes, and in it of the planes' places.
/// kBadInput names the field that is missing.
Result<std::vector<DicomPlane>> dicom_planes(DcmItem& dataset, std::uint32_t frames, const std::string& name);

/// The Volume to Transducer Mapping Matrix (PS3.3 C.8.24.2.2.1), row order; nullopt: there is none.
std::optional<ImagePose> volume_to_transducer(DcmItem& dataset);

/// The grid of parallel planes that stand at one distance; nullopt: they turn. `transducer`: the mapping
/// matrix, or zeros. kUnsupported: they are parallel, but form no grid.
Result<std::optional<VoxelGrid>> grid_of(const std::vector<DicomPlane>& planes, std::uint32_t columns,
                                         std::uint32_t rows, const ImagePose& transducer,
                                         const std::string& name);

}  // namespace fanlight
