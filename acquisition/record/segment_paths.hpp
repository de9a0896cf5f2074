// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace fanlight {

/// A part of a recording in progress: files next to the one that it will become.
/// FILE.rec-0001.pixels has the frames' pixels, one frame behind the other; FILE.rec-0001.frames has the
/// facts and a record for each frame, with the checksum of its pixels; FILE.rec-0001.pictures, where there
/// is one, has lines about the pictures that displays saw meanwhile. They only grow, so that whatever was
/// written before a crash can be read. A frame counts from when its record is whole.
struct SegmentPaths {
  std::filesystem::path frames;
  std::filesystem::path pixels;
  std::filesystem::path pictures;
};
SegmentPaths segment_paths(const std::filesystem::path& recording, std::uint32_t number);
/// The segments of a recording that are on the disk, in order of their numbers. Empty where there are none.
std::vector<SegmentPaths> segments_of(const std::filesystem::path& recording);
/// Names of the recordings in a folder of which there are segments and no whole file, in alphabetical order.
std::vector<std::filesystem::path> unfinished_recordings(const std::filesystem::path& folder);

/// Gives the files of segments the names of another recording's. False: some have the old ones; `segments`
/// tells.
bool rename_segments(std::vector<SegmentPaths>& segments, const std::filesystem::path& recording);

/// Keeps a recording to one process, from its first segment until its final file: two must not finish it at
/// once. Ends with this object or the process. A file system without locks, or a folder that cannot be
/// written, has no lock.
class RecordingLock {
 public:
  explicit RecordingLock(const std::filesystem::path& recording);
  ~RecordingLock();
  RecordingLock(const RecordingLock&) = delete;
  RecordingLock& operator=(const RecordingLock&) = delete;

  /// False: another process has it.
  bool held() const { return held_; }

 private:
  std::filesystem::path path_;
  int file_;
  bool held_;
};

/// Removes the files of each.
void remove_segments(const std::vector<SegmentPaths>& segments);

/// A second name of the finished file, FILE.rec-finished, from just before it gets its own until its segments
/// are removed: a kill leaves it beside those that were not, so that they are known to be needed no more. A
/// file system without hard links has no second name.
std::filesystem::path finished_mark(const SegmentPaths& segment);
/// Removes what a kill left of a recording with that name: its segments, and the name; the name alone where
/// the file is not there. Whether the recording is finished. The caller has the recording's lock.
bool remove_left_overs(const std::filesystem::path& recording);
/// Names of the recordings in a folder that have such a name.
std::vector<std::filesystem::path> recordings_with_left_overs(const std::filesystem::path& folder);

}  // namespace fanlight
