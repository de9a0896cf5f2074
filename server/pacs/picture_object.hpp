// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_series.hpp"

namespace fanlight {

/// A still picture for an archive.
struct PictureToSend {
  std::uint32_t width = 0;            ///< 1 to 65535
  std::uint32_t height = 0;           ///< 1 to 65535
  std::span<const std::uint8_t> rgb;  ///< height x width x 3, row major
  /// By how much it was compressed with a loss before; 0: it lost nothing.
  double lossy_ratio = 0;
  const char* lossy_method = "ISO_10918_1";  ///< JPEG; or ISO_14496_10, H.264 (PS3.3 C.7.6.1.1.5)
};

/// The bytes of a DICOM file: Secondary Capture Image (PS3.3 A.8.1), uncompressed RGB, explicit little
/// endian. It says that the picture is derived and has text in its pixels, and "Not for diagnosis". There is
/// no pixel size: a surface in perspective has none. Advances the series. kInvalidArgument: a size that does
/// not fit.
Result<std::vector<std::uint8_t>> picture_object(const PictureToSend& picture, DicomSeries& series);

/// Reads a picture file by the image library, and makes such an object of it. Grey and alpha become RGB on
/// black. kBadInput: not PNG, BMP, PNM or JPEG by its first bytes, of which it is known what they have
/// lost. kInvalidArgument, kUnavailable.
Result<std::vector<std::uint8_t>> picture_file_object(const std::filesystem::path& path, DicomSeries& series);

}  // namespace fanlight
