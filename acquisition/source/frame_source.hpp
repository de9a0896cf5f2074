// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/model/fan_geometry.hpp"
#include "proto/model/frame.hpp"
#include "proto/model/frame_origin.hpp"

namespace fanlight {

/// Properties of a source that are known before its first frame.
struct SourceDescription {
  std::string name;      ///< for display: "phantom:", "replay:liver.igs.mha"
  FanGeometry geometry;  ///< of the last announced frame; before the first one, of that frame
  std::uint64_t largest_frame_bytes =
      0;                       ///< largest frame of all geometries that it may change to; 0: none larger
  bool counts_volumes = true;  ///< stamps name their sweep; otherwise a sweep ends where the angle reverses
  bool is_grid = false;        ///< its frames are planes of a volume on a grid, which no probe swept
  std::uint32_t frames_per_volume = 0;  ///< largest number of frames in a sweep
  std::uint32_t usual_frames = 0;       ///< frames in a sweep at first; 0: frames_per_volume
  std::uint64_t volumes = 0;            ///< that it gives before it ends; 0: not known, or without end
  double first_angle_rad = 0;           ///< smallest and largest motor angle of a sweep
  double last_angle_rad = 0;
  std::int64_t begun_utc_s = 0;  ///< when a recording was begun, seconds since 1970; 0: not known
  FrameOrigin origin =
      FrameOrigin::kProbe;  ///< of its frames; of a network source, where the sender is silent
  bool simulated = false;   ///< it shows, or a recording of it, what suggested_scene() looks at
  /// What the source knows to be worth looking at, from the probe.
  struct Subject {
    Point middle;
    double height_mm = 0;  ///< what a picture has to show around it
  };
  std::optional<Subject> subject;
  /// What is assumed of the source, or was noticed about it; to be shown wherever its pictures are.
  std::vector<std::string> notes;
};

/// Source of frames: the interface that probe, recording and simulator share.
///
/// Life: created open -> next_frame(), read_pixels(), next_frame(), ... -> end. All calls come from one
/// thread, the acquisition thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Acquisition thread, or any thread before that one starts. The geometry changes together with the
  /// geometry_revision of a stamp.
  virtual const SourceDescription& description() const = 0;

  /// Blocks until the next frame is due and returns its stamp. nullopt at the end of the source, when `stop`
  /// is requested, or where it rests(). An Error means that the source cannot continue. Allocates nothing.
  virtual Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) = 0;

  /// After nullopt: the frames so far are whole sweeps, and others follow on request. The
  /// next call of next_frame() waits for that.
  virtual bool rests() const { return false; }

  /// Fault of that frame as far as it is known before its pixels; the pixels are then not read.
  virtual FrameFault known_fault() const { return FrameFault::kNone; }

  /// Whether it keeps a frame until the caller takes it, however late. A probe does not.
  virtual bool waits() const { return false; }

  /// Longest gap in the sequence numbers that counts as lost frames; a longer one is an interruption of the
  /// source. 0 where gaps are no losses: those of a recording, or of a simulation that was asked for them.
  virtual std::uint64_t longest_loss() const { return std::numeric_limits<std::uint64_t>::max(); }

  /// How often the source was later than its own times, so far.
  virtual std::uint64_t delays() const { return 0; }

  /// Writes the pixels of the frame that next_frame() announced: rows x columns bytes, row major, row 0
  /// nearest the probe. Blocks for pixels that are still to arrive. May be omitted to skip the frame. Returns
  /// the fault of a frame that did not arrive whole, or when `stop` is requested; the content of `pixels` is
  /// then undefined. Allocates nothing.
  virtual FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) = 0;
};

}  // namespace fanlight
