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
  /// Only the last seconds; 0: all.
  double last_s = 0;
  /// Compares the pixels with their checksums. A frame that differs counts as damaged: after a power cut,
  /// pages may not have reached the disk.
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
  std::uint64_t frames_damaged = 0;  ///< of them: their pixels did not reach the disk, and are 0
  std::uint64_t frames_lost = 0;     ///< not in it: only a part of what belongs to them was on the disk
  std::uint64_t bytes = 0;           ///< of the file, or of both files
  double duration_s = 0;
  std::uint64_t first_sequence = 0;  ///< smallest FrameStamp::sequence in it
  std::uint64_t last_sequence = 0;   ///< and greatest
};

/// Writes the PLUS sequence `path` from segments, which all have the same facts but for the time, and the
/// lines about its pictures next to it, and removes the segments. The new file appears whole or not at all,
/// with mode 0600, and never in place of another; until then the segments stay. A segment that is missing is
/// left out. One segment to an .mhd with raw pixels takes no copy; all else copies the pixels, and needs room
/// for them twice. Blocks; any thread, with the recording's lock. `stop` ends it early, with kStopped.
/// Errors: kUnavailable, no room, no permission or an I/O error; kInvalidArgument: a name is taken;
/// kNotFound: the segments have no frame.
Result<FinishedRecording> finish_recording(const std::vector<SegmentPaths>& segments,
                                           const std::filesystem::path& path, const FinishOptions& options,
                                           FinishProgress& progress, const std::stop_token& stop);

/// The same, but where there is no room for a copy of the pixels, they stay in the file that they are in:
/// x.igs.mhd with raw pixels stands in for x.igs.mha. Removes segments without anything.
Result<FinishedRecording> finish_in_any_form(const std::vector<SegmentPaths>& segments,
                                             const std::filesystem::path& path, const FinishOptions& options,
                                             FinishProgress& progress, const std::stop_token& stop);

}  // namespace fanlight
