// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recover_recording.hpp"

#include <fmt/format.h>

#include <vector>

#include "acquisition/record/recording_names.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

bool is_unfinished(const std::filesystem::path& path) {
  std::error_code failure;
  return !std::filesystem::exists(path, failure) && !segments_of(path).empty();
}

Result<FinishedRecording> recover_recording(const std::filesystem::path& path, const FinishOptions& options) {
  if (auto named = check_recording_name(path); !named) return named.error();
  const std::vector<SegmentPaths> segments = segments_of(path);
  std::error_code failure;
  if (std::filesystem::exists(path, failure)) {
    // A kill between the last two steps of finish_recording() leaves both. The reader removes them.
    const std::string left_over =
        segments.empty() ? ""
                         : fmt::format("; {} and the like are left over from it and may be removed",
                                       shown(segments.front().frames.filename()));
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("{} is a finished recording, expected one that was cut off{}", shown(path), left_over)};
  }
  if (segments.empty()) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: there is nothing of such a recording, expected {} or the like", shown(path),
                             shown(segment_paths(path, 1).frames.filename()))};
  }
  const RecordingLock lock(path);
  if (!lock.held()) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{}: another process records it or finishes it, expected its end", shown(path))};
  }
  FinishOptions checking = options;
  checking.check_pixels = true;
  FinishProgress progress;
  return finish_in_any_form(segments, path, checking, progress, std::stop_token());
}

}  // namespace fanlight
