// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/replay/fan_fit.hpp"
#include "acquisition/replay/image_orientation.hpp"
#include "acquisition/replay/pixel_values.hpp"
#include "proto/base/result.hpp"
#include "proto/model/frame.hpp"

namespace fanlight {

/// Header fields of one frame; absent where the header has none.
struct IgsFrame {
  std::optional<double> timestamp_s;
  std::optional<double> motor_angle_deg;
  std::optional<std::uint64_t> volume_index;
  std::optional<std::uint32_t> frame_index;
  std::optional<SweepDirection> direction;
  bool valid = true;              ///< its ImageStatus is not INVALID
  std::optional<ImagePose> pose;  ///< ImageToReferenceTransform, in the file's axis order

  // Of Fanlight's own recorder: see plus_fields.hpp and RecordedStream.
  std::optional<double> motor_angle_rad;
  std::optional<std::uint64_t> sequence;
  std::optional<std::uint32_t> frames_in_sweep;
  FrameFault fault = FrameFault::kNone;
  bool after_interruption = false;
};

/// A PLUS/IGSIO sequence file (.igs.mha, .mha; .mhd with the pixels in a separate file): a MetaImage whose
/// last axis is time, with fields/// Seq_Frame0000_Name for each frame, or a NRRD sequence (.seq.nrrd, .nrrd,
/// .nhdr) with the same fields. Supported: B-mode frames of 8 or 16 bit, scan converted or as scan lines, in
/// each orientation of ImageOrientation, plain or compressed with zlib. After reading, all have one axis
/// order: columns (or scan lines) ascend towards the marked side, rows (or samples) away from the probe.
/// Fields used: Timestamp (s), MotorAngleDeg, VolumeIndex, FrameIndex, ImageStatus, ImageToReferenceTransform
/// (mm), and Fanlight's own SweepDirection (FORWARD or BACKWARD).
struct IgsSequence {
  struct PixelSize {
    double width_mm;   ///< from column to column
    double height_mm;  ///< from row to row
  };

  /// How far a transform leads from the first frame's.
  struct Motion {
    std::array<double, 16> first{};  ///< matrix, row order
    double most_mm = 0;
    double most_deg = 0;
  };

  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  bool compressed = false;
  PixelFormat format;  ///< in the file; `pixels` are grey levels
  std::vector<IgsFrame> frames;
  std::optional<PixelSize> pixel_size;
  std::string_view pixel_size_origin = "its ImageToReferenceTransform";  ///< of the first frame that has one
  bool is_grid = false;  ///< the frames are planes of a volume on a grid; `fanlight_fields` is their geometry
  std::map<std::string, std::string, std::less<>> fanlight_fields;  ///< header fields named Fanlight...
  /// Transforms of the image or the probe (ProbeToTrackerTransform, ...), by name.
  std::map<std::string, Motion, std::less<>> motions;
  std::vector<std::string> notes;          ///< what the reader assumed, a sentence each
  std::unique_ptr<std::uint8_t[]> pixels;  ///< frames x rows x columns

  std::uint64_t frame_bytes() const { return std::uint64_t{columns} * rows; }
  std::span<const std::uint8_t> frame_pixels(std::size_t frame) const {
    return {pixels.get() + frame_bytes() * frame, frame_bytes()};
  }
};

/// What became of a file that is open.
enum class FileChange : std::uint8_t { kNone, kChanged, kRemoved };

/// The pixels of a sequence file, read frame by frame. Memory of one frame.
class IgsPixels {
 public:
  struct Reading;
  explicit IgsPixels(std::unique_ptr<Reading> reading);
  IgsPixels(IgsPixels&&) noexcept;
  IgsPixels& operator=(IgsPixels&&) noexcept;
  ~IgsPixels();

  /// Reads a frame, in Fanlight's axis order: rows x columns bytes. In order of the frames this is quick;
  /// else compressed pixels are unpacked from the first frame on. kBadInput: the file is damaged or cut off.
  Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to);

  /// Sets the window by which stored values become grey levels; whole_window() before. Precondition: read()
  /// was not called.
  void set_window(const ValueWindow& window);

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

/// A sequence without its pixels, and the file that has them.
struct OpenedSequence {
  IgsSequence sequence;
  IgsPixels pixels;
  ImageOrientation orientation;  ///< of the file; that of `pixels` is MF
};

/// Reads the header alone. The file is not trusted: at most max_bytes of pixels. kNotFound: no such file;
/// kUnsupported: another form of image; kUnavailable: not enough memory; else kBadInput. The message names
/// the file.
Result<OpenedSequence> open_igs_sequence(const std::filesystem::path& path, std::uint64_t max_bytes);

/// The files that open_igs_sequence() reads of a recording, the header first; of a series, all files of its
/// folder, by name. The header is read for it. Errors as of open_igs_sequence().
Result<std::vector<std::filesystem::path>> recording_files(const std::filesystem::path& path);

/// Chooses a window by the values of up to 64 frames of a file, evenly spread. Errors as of
/// open_igs_sequence() and IgsPixels::read().
Result<ValueWindow> choose_window(const std::filesystem::path& path, std::uint64_t max_bytes);

/// Reads all pixels into opened.sequence.pixels. Precondition: none was read. kUnavailable: no memory for
/// them; kBadInput: the file is damaged, cut off, or too long.
Result<void> read_all(OpenedSequence& opened);

/// Reads a whole sequence into memory. Errors as of the two functions above.
Result<IgsSequence> read_igs_sequence(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace fanlight
