// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "acquisition/replay/sequence_pixels.hpp"
#include "acquisition/sequence/frame_sequence.hpp"
#include "acquisition/sequence/image_orientation.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// A sequence without its pixels, and the file that has them.
struct OpenedSequence {
  FrameSequence sequence;
  SequencePixels pixels;
  ImageOrientation orientation;  ///< of the file; that of `pixels` is MF
};

/// Reads the header alone. The file is not trusted: at most max_bytes of pixels. kNotFound: no such file;
/// kUnsupported: another form of image; kUnavailable: not enough memory; else kBadInput. The message names
/// the file.
Result<OpenedSequence> open_recording_file(const std::filesystem::path& path, std::uint64_t max_bytes);

/// The files that open_recording_file() reads of a recording, the header first; of a series, all files of its
/// folder, by name. The header is read for it. Errors as of open_recording_file().
Result<std::vector<std::filesystem::path>> recording_files(const std::filesystem::path& path);

/// Chooses a window by the values of up to 64 frames of a file, evenly spread, without those of pixels that
/// were not scanned. Errors as of open_recording_file() and SequencePixels::read().
Result<ValueWindow> choose_window(const std::filesystem::path& path, std::uint64_t max_bytes,
                                  Unscanned unscanned = Unscanned::kDetect);

/// Reads all pixels into opened.sequence.pixels. Precondition: none was read. kUnavailable: no memory for
/// them; kBadInput: the file is damaged, cut off, or too long.
Result<void> read_all(OpenedSequence& opened);

/// Reads a whole sequence into memory. Errors as of the two functions above.
Result<FrameSequence> read_recording_file(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace fanlight
