// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "acquisition/convert/grid_volume.hpp"
#include "proto/base/result.hpp"
#include "proto/dicom/identity.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

/// What a file says of where its volume is from.
struct DicomSource {
  FanGeometry geometry;
  std::int64_t acquired_utc_s = 0;  ///< seconds since 1970; 0: not known
  DicomIdentity identity;
  bool is_simulated = false;
  /// When the study began, seconds since 1970; 0: not known. Absent: with the acquisition.
  std::optional<std::int64_t> study_began_utc_s{};
};

/// Writes a volume as a DICOM Enhanced US Volume (PS3.3 A.59), explicit little endian, by DCMTK. Its axes are
/// those of DICOM's Transducer Frame of Reference (PS3.3 C.8.24.2.1.2): x towards the marked side, y into the
/// body, from the centre of the face; so the mapping matrix is the unit matrix. Of the
/// identity, what is not known is empty, and the study is new then. Errors as of NewFile; kInvalidArgument: a
/// voxel grid of over 4 GB.
Result<void> write_grid_dicom(const std::filesystem::path& path, const GridVolume& grid,
                              const DicomSource& source);

/// The bytes of such a file. Errors as above, without those of files.
Result<std::vector<std::uint8_t>> grid_dicom(const GridVolume& grid, const DicomSource& source);

}  // namespace fanlight
