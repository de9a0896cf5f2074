// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "acquisition/replay/frame_reader.hpp"
#include "acquisition/replay/recording_file.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// Frames in numbered picture files, or in a video, read by OpenImageIO: every picture format and codec that
/// it was built with. Colour is read as luminance (ITU-R BT.601). One thread.
class ImageSeries : public FrameReader {
 public:
  /// A folder, or a pattern such as "scan/frame.%04d.png".
  static bool is_series(const std::filesystem::path& path);

  /// In a folder, the pictures in the order of the last number in their names; all must have one ending. Of a
  /// pattern, the files from the first to the last number that is there; a gap is an error. kNotFound,
  /// kUnsupported, else kBadInput; the message names the file.
  static Result<std::unique_ptr<ImageSeries>> open(const std::filesystem::path& path);

  ~ImageSeries() override;

  std::uint32_t columns() const;
  std::uint32_t rows() const;
  std::uint64_t frames() const;
  PixelFormat format() const;  ///< 8 or 16 bit, of this machine's byte order

  /// Reads a frame: rows x columns values of format().bytes each. kBadInput: it cannot be read, or has
  /// another size.
  Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to) override;

 private:
  struct State;
  explicit ImageSeries(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// As open_recording_file(), of a series: frames without angles and times.
Result<FrameSequence> series_frames(const std::filesystem::path& path, const ImageSeries& series,
                                    std::uint64_t max_bytes);

}  // namespace fanlight
