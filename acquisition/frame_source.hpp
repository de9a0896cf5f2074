#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "proto/fan_geometry.hpp"
#include "proto/frame.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// What is known of a source before its first frame.
struct SourceDescription {
  std::string name;                       ///< for a person: "phantom:", "replay:liver.igs.mha"
  FanGeometry geometry;                   ///< of the frame announced last; before the first, of that one
  std::uint64_t largest_frame_bytes = 0;  ///< of the geometries that it may change to; 0: none larger
  bool counts_volumes = true;           ///< stamps name their sweep; otherwise it ends where the angle turns
  std::uint32_t frames_per_volume = 0;  ///< the most frames a sweep can have
  std::uint32_t usual_frames = 0;       ///< as many as sweeps have at first; 0: frames_per_volume
  double first_angle_rad = 0;           ///< smallest and largest motor angle of a sweep
  double last_angle_rad = 0;
};

/// Where frames come from: the seam that a probe, a recording and the simulator share.
///
/// Life: created open -> next_frame(), read_pixels(), next_frame(), ... -> end. All calls come from one
/// thread, the acquisition thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Acquisition thread, or any before it starts. Its geometry changes where a stamp's geometry_revision
  /// does.
  virtual const SourceDescription& description() const = 0;

  /// Waits until the next frame is due and returns its stamp; nullopt at the end of the source, or as soon
  /// as `stop` is requested. An Error means that the source cannot go on. Allocates nothing.
  virtual Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) = 0;

  /// What is already known to be wrong with that frame; its pixels are then not read.
  virtual FrameFault known_fault() const { return FrameFault::kNone; }

  /// Writes the pixels of the frame that next_frame() just announced: rows x columns bytes, row major, row
  /// 0 nearest the probe. Waits for those that are still to come. May be left out to skip the frame. The
  /// fault of a frame that did not come whole, or as soon as `stop` is requested; `pixels` then hold
  /// anything. Allocates nothing.
  virtual FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) = 0;
};

}  // namespace fanlight
