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
  std::string name;  ///< for a person: "phantom:", "replay:liver.igs.mha"
  FanGeometry geometry;
  std::uint32_t frames_per_volume = 0;  ///< the most frames a sweep can have
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

  virtual const SourceDescription& description() const = 0;

  /// Waits until the next frame is due and returns its stamp; nullopt at the end of the source, or as soon
  /// as `stop` is requested. An Error means that the source cannot go on. Allocates nothing.
  virtual Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) = 0;

  /// Writes the pixels of the frame that next_frame() just announced: rows x columns bytes, row major, row
  /// 0 nearest the probe. May be left out to skip the frame. Allocates nothing.
  virtual void read_pixels(std::span<std::uint8_t> pixels) = 0;

  /// Whether that frame is marked unusable by its maker; its pixels are then not read.
  virtual bool frame_invalid() const { return false; }
};

}  // namespace fanlight
