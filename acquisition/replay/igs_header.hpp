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
  std::uint64_t header_bytes = 0;                 ///< offset of the pixels
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

/// Reads the header, up to the first byte of the pixels, and checks it: at most `max_bytes` of pixels, and no
/// more than the rest of the file can hold. kUnsupported for other forms of image, else kBadInput.
Result<IgsHeader> read_igs_header(const IgsFile& from, std::uint64_t max_bytes);

}  // namespace fanlight
