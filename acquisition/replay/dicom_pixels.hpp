// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/replay/frame_reader.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "proto/base/result.hpp"

class DcmDataset;
class DcmFileFormat;

namespace fanlight {

/// How the samples of a pixel lie in a DICOM file (PS3.3 C.7.6.3).
struct SampleLayout {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint32_t samples = 1;  ///< of a pixel: 1, or 3 of a colour
  std::uint32_t allocated_bytes = 1;
  std::uint32_t stored_bits = 8;
  std::uint32_t lowest_bit = 0;
  bool is_signed = false;
  bool is_planar = false;
  bool is_inverted = false;  ///< MONOCHROME1
  std::string colours;       ///< Photometric Interpretation
  bool is_compressed = false;

  PixelFormat format() const;
  /// Bytes of a frame that is not compressed.
  std::uint64_t frame_bytes() const;
};

/// kUnsupported names a layout that is not read; kBadInput: out of range.
Result<SampleLayout> dicom_layout(DcmDataset& dataset, const std::string& name);

/// A part of the picture.
struct Crop {
  std::uint32_t left = 0;
  std::uint32_t top = 0;
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
};

/// Reads the part of the frames with these numbers as grey values of layout.format(). Error: kBadInput where
/// the file has no pixels.
Result<std::unique_ptr<FrameReader>> dicom_reader(const std::string& name,
                                                  std::unique_ptr<DcmFileFormat> file,
                                                  const SampleLayout& layout, const Crop& crop,
                                                  std::vector<std::uint32_t> frames);

}  // namespace fanlight
