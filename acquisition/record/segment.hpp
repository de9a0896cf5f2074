// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/segment_paths.hpp"
#include "acquisition/sequence/recorded_frame.hpp"
#include "proto/base/owned_file.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// Writes a segment. Not thread safe; the recorder's thread.
class SegmentWriter {
 public:
  /// Creates both files (mode 0600). kUnavailable: the sentence says why.
  static Result<SegmentWriter> create(const SegmentPaths& paths, const RecordingFacts& facts);

  /// `pixels`: of the facts' geometry, rows x columns bytes, row major; ignored for an unusable frame. The
  /// record stays in memory until flush(). kUnavailable: no room, or an I/O error. Nothing of the frame is
  /// then kept, and the frames before it are still whole.
  Result<void> append(const RecordedFrame& frame, std::span<const std::uint8_t> pixels);
  /// Appends a line about a picture, without its end. Errors as of append(); the line is then lost.
  Result<void> add_picture(std::string_view line);

  /// Writes the records of all frames so far; then a kill of the process loses none of them.
  Result<void> flush();

  const SegmentPaths& paths() const { return paths_; }
  std::uint64_t frames() const { return frames_; }
  /// Of these, those whose records flush() has not written.
  std::uint64_t unflushed_frames() const { return frames_ - flushed_frames_; }
  std::int64_t first_time_ns() const { return first_time_ns_; }
  std::int64_t last_time_ns() const { return last_time_ns_; }

 private:
  SegmentWriter() = default;
  Error failed(const std::filesystem::path& path, int reason) const;

  SegmentPaths paths_;
  OwnedFile frames_file_;
  OwnedFile pixels_file_;
  OwnedFile pictures_file_;  // opened with the first line
  std::uint64_t picture_bytes_ = 0;
  std::uint64_t frame_bytes_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t flushed_frames_ = 0;
  std::uint64_t pixel_bytes_ = 0;
  std::uint64_t record_bytes_ = 0;  // of the file with the records, as far as they are whole
  std::int64_t first_time_ns_ = 0;
  std::int64_t last_time_ns_ = 0;
  std::vector<std::uint8_t> zeros_;
  std::string unwritten_;  // records
};

/// A segment read back. The files are not trusted.
struct Segment {
  SegmentPaths paths;
  RecordingFacts facts;
  std::vector<RecordedFrame> frames;
  std::vector<std::uint32_t> pixel_checksums;  ///< CRC-32C of each frame's pixels
  std::uint64_t records = 0;                   ///< whole ones, also of frames whose pixels are not there
};

/// Reads the records whose pixels are on the disk. Records behind a damaged one are left out. kNotFound: one
/// of the files is missing; kUnavailable: it cannot be read; kBadInput: these are no files of a segment.
Result<Segment> read_segment(const SegmentPaths& paths);

}  // namespace fanlight
