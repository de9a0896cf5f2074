// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recover_recording.hpp"

#include <fmt/format.h>

#include <vector>

#include "acquisition/record/recording_names.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

/// Segments beside a file of their recording's name, for an error message: a kill may have left them, or
/// another program may have put the file there.
std::string beside(const std::vector<SegmentPaths>& segments) {
  if (segments.empty()) return "";
  return fmt::format(
      "; {} and the like may be left over from it: if it lacks frames, rename it and recover them",
      shown(segments.front().frames.filename()));
}

}  // namespace

bool is_unfinished(const std::filesystem::path& path) {
  std::error_code failure;
  return !std::filesystem::exists(path, failure) && !segments_of(path).empty();
}

Result<FinishedRecording> recover_recording(const std::filesystem::path& path, const FinishOptions& options) {
  if (auto named = check_recording_name(path); !named) return named.error();
  const RecordingLock lock(path);
  if (!lock.held()) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{}: another process records it or finishes it, expected its end", shown(path))};
  }
  // A kill in the last step of finish_recording().
  const bool finished = remove_left_overs(path);
  const std::vector<SegmentPaths> segments = segments_of(path);
  std::error_code failure;
  if (finished || std::filesystem::exists(path, failure)) {
    std::filesystem::path file = path;
    if (!std::filesystem::exists(path, failure)) file.replace_extension(".mhd");  // see finish_in_any_form()
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} is a finished recording, expected one that was cut off{}", shown(file),
                             beside(segments))};
  }
  if (segments.empty()) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: there is nothing of such a recording, expected {} or the like", shown(path),
                             shown(segment_paths(path, 1).frames.filename()))};
  }
  FinishOptions checking = options;
  checking.check_pixels = true;
  FinishProgress progress;
  return finish_in_any_form(segments, path, checking, progress, std::stop_token());
}

}  // namespace fanlight
