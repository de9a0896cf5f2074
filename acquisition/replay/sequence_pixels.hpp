// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "acquisition/replay/frame_reader.hpp"
#include "acquisition/sequence/pixel_values.hpp"
#include "proto/base/result.hpp"

namespace fanlight {

/// What became of a file that is open.
enum class FileChange : std::uint8_t { kNone, kChanged, kRemoved };

/// The pixels of a sequence file, read frame by frame. Memory of one frame.
class SequencePixels {
 public:
  struct Reading;
  explicit SequencePixels(std::unique_ptr<Reading> reading);
  SequencePixels(SequencePixels&&) noexcept;
  SequencePixels& operator=(SequencePixels&&) noexcept;
  ~SequencePixels();

  /// Reads a frame, in Fanlight's axis order: rows x columns bytes. In order of the frames this is quick;
  /// else compressed pixels are unpacked from the first frame on. kBadInput: the file is damaged or cut off.
  Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to);

  /// Sets the window by which stored values become grey levels; whole_window() before. Precondition: read()
  /// was not called.
  void set_window(const ValueWindow& window);

  /// Finds the pixels that were not scanned: with a code in the answer read() makes them 0 and all others 1
  /// or more, and count() leaves them out. Only for volumes on a grid. Preconditions: `wanted` is not kNone;
  /// neither read() nor set_window() was called.
  UnscannedPixels mark_unscanned(Unscanned wanted);

  /// As read(), but counts the stored values.
  Result<void> count(std::uint64_t frame, ValueHistogram& histogram);

  /// The stored values of all frames, in the file's order. Precondition: read() was not called. Errors as of
  /// read() and finish(); kUnavailable: no memory.
  Result<std::vector<std::uint8_t>> stored_values();

  /// Whether the first frame looks like an image of `rows` columns and `columns` rows: DimSize may have its
  /// first two numbers in the wrong order. Precondition: read() was called.
  bool looks_transposed() const;

  /// Whether the last frame was read.
  bool at_end() const;

  /// Whether each frame is found without reading those before it.
  bool has_quick_access() const;

  /// Whether the file was written to, or its name removed, since it was opened. A call of the system.
  FileChange change() const;

  /// After the last frame: kBadInput where pixels follow it, or the checksum is wrong.
  Result<void> finish();

 private:
  std::unique_ptr<Reading> reading_;
};

}  // namespace fanlight
