// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "proto/base/file_replacement.hpp"
#include "proto/base/folder_beneath.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// Writes a stream of H.264 pictures as an MP4 video, as they come. Our own writer: the well-kept libraries
/// that Debian has (FFmpeg, GStreamer's plugin) are built with GPL parts or need a whole media framework.
/// Source: ISO/IEC 14496-12 and 14496-15. Memory of 16 bytes a picture. One thread.
class Mp4File {
 public:
  /// The file gets its name in finish(), in place of what is there.
  /// `beneath`: as FileAccess::beneath.
  Mp4File(std::filesystem::path path, std::uint32_t width, std::uint32_t height,
          std::filesystem::path beneath = {})
      : path_(std::move(path)), width_(width), height_(height), beneath_(std::move(beneath)) {}

  /// Adds a picture as H264Coder makes it (Annex B, parameter sets in key pictures), which is shown from
  /// `time_ns` on until the next one. The first must be a key picture. kUnavailable: the disk refuses.
  Result<void> add(std::span<const std::uint8_t> annex_b, bool key, std::int64_t time_ns);

  /// Writes the index and gives the file its name. The last picture is shown as long as the one before it.
  /// Precondition: at least one picture.
  Result<void> finish();

 private:
  class Index;
  Result<void> begin();
  Result<void> as_result(int failure) const;
  /// In ticks of the video, from 0.
  std::vector<std::uint32_t> durations() const;

  struct Sample {
    std::int64_t time_ns;
    std::uint32_t bytes;
    bool key;
  };

  std::filesystem::path path_;
  std::uint32_t width_;
  std::uint32_t height_;
  std::filesystem::path beneath_;
  FolderBeneath folder_;  // used where there is beneath_
  std::filesystem::path target_;
  ReplacementFile file_;
  std::uint64_t data_bytes_ = 0;
  std::vector<Sample> samples_;
  std::vector<std::uint8_t> sequence_set_;  // the parameter sets, each without a start code
  std::vector<std::uint8_t> picture_set_;
  std::vector<std::uint8_t> sample_;
};

}  // namespace fanlight
