// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/record/segment.hpp"
#include "proto/exchange/recording_link.hpp"

namespace fanlight {

struct FinishOptions {
  PixelForm form = PixelForm::kRaw;
  /// Only the last so many seconds; 0: all.
  double last_s = 0;
  /// Compares the pixels with their checksums and leaves out what follows the first that differs: after a
  /// power cut, the last pages may not have reached the disk.
  bool check_pixels = false;
};

/// Progress of a finish that another thread watches.
struct FinishProgress {
  std::atomic<std::uint64_t> bytes_done{0};
  std::atomic<std::uint64_t> bytes_in_all{0};
};

struct FinishedRecording {
  std::filesystem::path path;
  std::uint64_t frames = 0;
  std::uint64_t frames_left_out = 0;  ///< their pixels did not reach the disk
  std::uint64_t bytes = 0;            ///< of the file, or of both files
  double duration_s = 0;
};

/// Whether `path` can be the name of a recording: it ends with .mha (one file) or .mhd (the header, and
/// beside it the pixels in a file .raw or .zraw). kInvalidArgument says what was expected.
Result<void> check_recording_name(const std::filesystem::path& path);
/// The file with the pixels of an .mhd: x.igs.mhd -> x.igs.raw or x.igs.zraw.
std::filesystem::path pixels_beside(const std::filesystem::path& path, PixelForm form);

/// The lines about the pictures that displays saw: x.igs.mha -> x.igs.mha.pictures.jsonl.
std::filesystem::path pictures_beside(const std::filesystem::path& path);

/// Writes the PLUS sequence `path` from segments, which all have the same facts but for the time, and the
/// lines about its pictures beside it, and removes the segments. The new file appears whole or not at all,
/// with mode 0600; until then the segments stay. One segment to an .mhd with raw pixels takes no copy and no
/// time; all else copies the pixels, and needs room for them twice. Blocks; any thread. `stop` ends it early,
/// with kStopped. Errors: kUnavailable, no room or no permission; kNotFound: the segments have no frame;
/// those of read_segment().
Result<FinishedRecording> finish_recording(const std::vector<SegmentPaths>& segments,
                                           const std::filesystem::path& path, const FinishOptions& options,
                                           FinishProgress& progress, const std::stop_token& stop);

/// Removes both files of each.
void remove_segments(const std::vector<SegmentPaths>& segments);

}  // namespace fanlight
