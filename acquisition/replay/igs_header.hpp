// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/replay/header_lines.hpp"
#include "acquisition/replay/igs_sequence.hpp"
#include "acquisition/replay/image_orientation.hpp"
#include "acquisition/replay/pixel_values.hpp"
#include "acquisition/replay/voxel_grid.hpp"

namespace fanlight {

/// Text header of a sequence file.
struct IgsHeader {
  IgsSequence sequence;  ///< all but the pixels; columns, rows and pixel size in the file's axis order
  ImageOrientation orientation;
  PixelFormat format;
  bool gzip = false;               ///< the compressed pixels are a gzip file, not a zlib stream
  std::uint64_t frames = 0;        ///< of DimSize
  std::uint64_t header_bytes = 0;  ///< of the text
  std::string data_file;           ///< next to this one; empty: the pixels follow the text
  std::optional<std::uint64_t> compressed_bytes;  ///< CompressedDataSize
  bool frames_first = false;  ///< the first pixels of all frames come first, then all second ones
  /// The file is no sequence: its `frames` are the slices of these volumes.
  std::optional<VoxelGrid> grid;
};

/// Takes the name of a file with the pixels. Nothing outside of the header's own folder is opened:
/// kUnsupported for a path, a list or a pattern.
Result<void> take_data_file(const IgsFile& from, const HeaderField& field, IgsHeader& header);

/// Reads the text of a MetaImage, up to its last line, and checks it. The list of frames is as long as the
/// lines describe. kUnsupported for other forms of image, else kBadInput.
Result<IgsHeader> read_igs_header(const IgsFile& from);

/// Completes the list of frames, once the size of the pixels' file is known: at most `max_bytes` of pixels,
/// and no more than `present` bytes can hold. kBadInput.
Result<void> complete_frames(const IgsFile& from, IgsHeader& header, std::uint64_t present,
                             std::uint64_t max_bytes);

}  // namespace fanlight
