// SPDX-License-Identifier: Apache-2.0
// In place of dicom_volume.cpp in a build without DCMTK.
#include "acquisition/convert/dicom_volume.hpp"

namespace fanlight {

namespace {

Error missing() {
  return {ErrorCode::kUnsupported,
          "this program was built without DCMTK, expected one built with FANLIGHT_DICOM=ON"};
}

}  // namespace

Result<void> write_grid_dicom(const std::filesystem::path&, const GridVolume&, const DicomSource&) {
  return missing();
}

Result<std::vector<std::uint8_t>> grid_dicom(const GridVolume&, const DicomSource&) {
  return missing();
}

}  // namespace fanlight
