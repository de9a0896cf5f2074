// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_series.hpp"

namespace fanlight {

/// Width, height and channels of a baseline JPEG (ITU-T T.81, process 1), from its frame header.
struct JpegShape {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 0;

  bool operator==(const JpegShape&) const = default;
};

/// kBadInput: it is no JPEG, or not baseline with 8 bits and three channels.
Result<JpegShape> jpeg_shape(std::span<const std::uint8_t> jpeg);

using Jpegs = std::vector<std::vector<std::uint8_t>>;

/// The bytes of a DICOM file: Ultrasound Multi-frame Image (PS3.3 A.7), whose frames are these JPEG files as
/// they are. `frames_per_second`: above 0. Advances the series. At most 1 GB in all, read into memory.
/// kNotFound, kBadInput: a file is no baseline JPEG, or has another size than the first; kInvalidArgument.
Result<std::vector<std::uint8_t>> clip_object(std::span<const std::filesystem::path> files,
                                              double frames_per_second, DicomSeries& series);
/// The same of JPEG files in memory.
Result<std::vector<std::uint8_t>> clip_object(const Jpegs& jpegs, double frames_per_second,
                                              DicomSeries& series);

}  // namespace fanlight
