// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "acquisition/replay/frame_reader.hpp"
#include "acquisition/replay/voxel_grid.hpp"
#include "acquisition/sequence/frame_sequence.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// A DICOM file: an ultrasound multi-frame image, or an Enhanced US Volume.
struct DicomFile {
  /// The frames that are tissue. Of a multi-frame image with times where it has them, and the pixel size of
  /// its calibrated region, to which they are cut. Of volumes whose planes are not parallel with their poses.
  FrameSequence sequence;
  std::unique_ptr<FrameReader> reader;
  /// Of volumes with parallel planes: `sequence` is their slices then, one volume after the other.
  std::optional<VoxelGrid> grid;
};

/// Registers DCMTK's decoders and silences its log, which are global: what matters is in our own messages.
void prepare_dicom_library();

/// Whether a file that begins with these bytes is DICOM: "DICM" behind 128 bytes.
bool is_dicom(std::span<const unsigned char> first_bytes);

/// Reads the file with DCMTK: pixels plain, RLE, JPEG or JPEG-LS, of 8 or 16 bit; colour as luminance
/// (ITU-R BT.601). No field about the patient is looked at. The file is not trusted: at most max_bytes of
/// pixels. kUnsupported names what is not read; else kBadInput. The message names the file.
Result<DicomFile> open_dicom(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace fanlight
