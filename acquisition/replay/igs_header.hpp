// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/replay/igs_sequence.hpp"
#include "acquisition/replay/image_orientation.hpp"

namespace fanlight {

/// Text header of a sequence file.
struct IgsHeader {
  IgsSequence sequence;  ///< all but the pixels; columns, rows and pixel size in the file's axis order
  ImageOrientation orientation;
  std::uint64_t frames = 0;                       ///< of DimSize
  std::uint64_t header_bytes = 0;                 ///< of the text
  std::string data_file;                          ///< beside this one; empty: the pixels follow the text
  std::optional<std::uint64_t> compressed_bytes;  ///< CompressedDataSize
};

/// A file that is being read. It is not trusted.
struct IgsFile {
  std::string name;           ///< for error messages
  std::FILE* file = nullptr;  ///< at its first byte
  std::uint64_t bytes = 0;

  /// "NAME: WRONG, expected EXPECTED".
  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const;
};

/// Reads the text, up to its last line, and checks it. The list of frames is as long as the lines describe.
/// kUnsupported for other forms of image, else kBadInput.
Result<IgsHeader> read_igs_header(const IgsFile& from);

/// Completes the list of frames, once the size of the pixels' file is known: at most `max_bytes` of pixels,
/// and no more than `present` bytes can hold. kBadInput.
Result<void> complete_frames(const IgsFile& from, IgsHeader& header, std::uint64_t present,
                             std::uint64_t max_bytes);

}  // namespace fanlight
