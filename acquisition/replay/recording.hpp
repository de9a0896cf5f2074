// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/finish_recording.hpp"
#include "acquisition/replay/recording_file.hpp"
#include "acquisition/sequence/recorded_stream.hpp"
#include "acquisition/sequence/recording_geometry.hpp"
#include "proto/base/result.hpp"
#include "proto/model/frame.hpp"

namespace fanlight {

/// Properties of a recording, for display.
struct RecordingSummary {
  std::string name;  ///< path as given by the user
  std::uint32_t frames = 0;
  std::uint32_t frames_invalid = 0;  ///< marked as invalid in the file
  std::uint64_t frames_lost = 0;     ///< gaps of FrameIndex: lost while it was recorded
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  bool compressed = false;
  PixelFormat format;
  ValueWindow window;  ///< of values that are no grey levels
  std::uint32_t sweeps = 0;
  std::uint32_t frames_in_longest_sweep = 0;
  double smallest_angle_deg = 0;
  double largest_angle_deg = 0;
  double duration_s = 0;  ///< from the first frame to the last
  double frame_rate_hz = 0;
  FanGeometry geometry;
  std::vector<RecordingGeometry::Value> geometry_values;
  std::uint32_t angle_outliers = 0;  ///< among frames_invalid: their angle is apart from their neighbours'
  std::vector<std::string> notes;    ///< what is assumed or was noticed, a sentence each
};

/// A recording of a swept probe: frames with their angles, divided into sweeps.
///
/// Sweeps follow the field VolumeIndex. Where no frame has it, they end at reversals of the angle, at each of
/// which it must come back by 1 deg, to tolerate an unsteady hand. The direction of a sweep is the sign of
/// the angle difference from its first to its last frame. Angles are MotorAngleDeg; frames whose angle is an
/// outlier (AngleCheck) are invalid. Where no frame has one, angles are spread evenly over each sweep
/// (RecordingGeometry), backward where SweepDirection says so, and a note says that they are assumed.
///
/// Frames of Fanlight's own recorder keep what their source said of them (stream()): no angle is judged here,
/// so that the assembler judges it, as it did when the frame came.
class Recording {
 public:
  /// How pixels are read.
  enum class Pixels : std::uint8_t {
    kAll,       ///< open() reads all of them into memory
    kFromFile,  ///< read_frame() reads the file: memory of one frame
  };
  struct Config {
    std::filesystem::path path;
    std::filesystem::path geometry_path;               ///< empty: FILE.toml or the file's own header
    std::uint64_t max_bytes = std::uint64_t{8} << 30;  ///< of pixels in all
    Pixels pixels = Pixels::kAll;
  };

  struct Frame {
    double angle_rad = 0;      ///< 0 for an invalid frame without one
    std::int64_t time_ns = 0;  ///< since the first frame
    std::uint32_t sweep = 0;
    std::uint32_t lost_before = 0;  ///< missing frames of the sweep between the previous frame and this one
    bool valid = true;
  };
  struct Sweep {
    std::uint32_t first_frame = 0;
    std::uint32_t frames = 0;
    std::uint64_t volume_index = 0;  ///< from the file, or counted from 0
    SweepDirection direction = SweepDirection::kForward;
  };

  /// Reads the header and the first frame, and with Pixels::kAll the others. The file is not trusted.
  /// Finishes the recording first, where its recorder was cut off (recover_recording()). Errors as of
  /// open_recording_file, read_all and find_geometry; also kBadInput where the frames give no sweep: angles
  /// or times are missing or do not change, or the probe was moved by a hand or a stepper.
  static Result<Recording> open(const Config& config);

  const RecordingSummary& summary() const { return summary_; }
  /// Whether the frames are planes of a volume on a grid.
  bool is_grid() const { return sequence_.is_grid; }
  const std::vector<Frame>& frames() const { return frames_; }  ///< in order of time, at least 2
  const std::vector<Sweep>& sweeps() const { return sweeps_; }  ///< in order of time, at least 1
  /// What Fanlight's recorder wrote; nullptr: Fanlight did not write the recording.
  const RecordedStream* stream() const { return stream_ ? &*stream_ : nullptr; }
  /// With Pixels::kAll.
  std::span<const std::uint8_t> frame_pixels(std::size_t frame) const {
    return sequence_.frame_pixels(frame);
  }
  /// Copies a frame's pixels. Error: as of SequencePixels::read().
  Result<void> read_frame(std::size_t frame, std::span<std::uint8_t> to);
  /// Whether frames may be read in any order without delay.
  bool has_quick_access() const { return !pixels_ || pixels_->has_quick_access(); }
  /// With Pixels::kAll the file does not matter any more: kNone.
  FileChange file_change() const { return pixels_ ? pixels_->change() : FileChange::kNone; }
  /// After the last frame. With Pixels::kFromFile: kBadInput where the file's checksum is wrong, or pixels
  /// follow the last frame.
  Result<void> finish();
  /// Reads all compressed pixels, up to kMostChecked bytes of them, and their checksum: a damaged byte may
  /// give other pixels and no error where it lies. Errors as of read_frame() and finish(); nothing where
  /// pixels are not compressed, or are more. Takes as long as the decompression.
  Result<void> check_pixels();
  static constexpr std::uint64_t kMostChecked = std::uint64_t{2} << 30;

 private:
  Recording(const Config& config, OpenedSequence opened);

  Result<void> read_first_frame();
  Result<void> find_times();
  Result<void> find_angles_and_sweeps(const RecordingGeometry& geometry);
  Result<void> cut_at_volume_index();
  void cut_at_turning_points();
  void begin_sweep(std::uint32_t first_frame, std::uint64_t volume_index);
  void cut_as_recorded();
  void close_sweeps();
  void spread_angles(double first_deg, double last_deg);
  std::uint32_t lost_before(std::size_t frame) const;
  void exclude_spikes();
  void exclude_outliers();
  void exclude_outliers(std::uint32_t first_frame, std::uint32_t end_frame);
  void find_directions();
  void find_lost_frames();
  Result<void> summarise(const RecordingGeometry& geometry);
  void add_notes(const RecordingGeometry& geometry);
  void add_note(const FinishedRecording& recovered);

  Error bad(std::string_view wrong, std::string_view expected) const;

  FrameSequence sequence_;
  std::optional<SequencePixels> pixels_;   // with Pixels::kFromFile
  std::vector<std::uint8_t> first_frame_;  // then: its pixels
  bool transposed_ = false;                // the frames look like it
  bool measured_ = true;                   // the frames have angles
  bool angles_given_ = false;              // by lists of the geometry
  std::uint32_t contradictions_ = 0;       // sweeps whose SweepDirection contradicts their angles
  std::optional<RecordedStream> stream_;
  std::vector<Frame> frames_;
  std::vector<Sweep> sweeps_;
  RecordingSummary summary_;
};

}  // namespace fanlight
