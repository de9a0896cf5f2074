// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/replay/header_lines.hpp"
#include "acquisition/replay/voxel_grid.hpp"
#include "acquisition/sequence/frame_sequence.hpp"
#include "acquisition/sequence/image_orientation.hpp"
#include "acquisition/sequence/pixel_values.hpp"

namespace fanlight {

/// Time between the frames of a file that has no times.
inline constexpr double kAssumedFrameS = 0.01;

/// Text header of a sequence file.
struct SequenceHeader {
  FrameSequence sequence;  ///< all but the pixels; columns, rows and pixel size in the file's axis order
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
Result<void> take_data_file(const NamedFile& from, const HeaderField& field, SequenceHeader& header);

/// Reads the text of a MetaImage, up to its last line, and checks it. The list of frames is as long as the
/// lines describe. kUnsupported for other forms of image, else kBadInput.
Result<SequenceHeader> read_meta_image_header(const NamedFile& from);

/// Completes the list of frames, once the size of the pixels' file is known: at most `max_bytes` of pixels,
/// and no more than `present` bytes can hold. kBadInput.
Result<void> complete_frames(const NamedFile& from, SequenceHeader& header, std::uint64_t present,
                             std::uint64_t max_bytes);

}  // namespace fanlight
