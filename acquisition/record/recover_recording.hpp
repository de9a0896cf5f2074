// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "acquisition/record/finish_recording.hpp"

namespace fanlight {

/// Finishes a recording that was cut off: by a crash of the recorder, or by a disk that was full. `path`: the
/// name that it was to have. Frames whose pixels are not on the disk are left out. Errors: kNotFound, where
/// nothing of it is there, or no whole frame; kInvalidArgument, where the recording is finished;
/// kUnavailable, where another process still records, or finish_recording() has no room.
Result<FinishedRecording> recover_recording(const std::filesystem::path& path, const FinishOptions& options);

/// Whether there is no such file, but parts of a recording that was to have this name.
bool is_unfinished(const std::filesystem::path& path);

}  // namespace fanlight
