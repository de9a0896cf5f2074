// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/tracked_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/source/printable.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

ImagePose turned(ImagePose pose, const ImageOrientation& orientation, FrameSize size) {
  const auto turn = [&pose](std::size_t axis, std::uint32_t length) {
    for (std::size_t row = 0; row < 3; ++row) {
      pose[4 * row + 3] += pose[4 * row + axis] * (length - 1);
      pose[4 * row + axis] = -pose[4 * row + axis];
    }
  };
  if (orientation.towards_unmarked) turn(0, size.columns);
  if (orientation.towards_near) turn(1, size.rows);
  return pose;
}

Result<std::optional<FanFit>> fit_poses(const std::filesystem::path& path, FrameSequence& sequence,
                                        const ImageOrientation& orientation) {
  std::vector<ImagePose> poses;
  for (const SequenceFrame& frame : sequence.frames) {
    if (frame.motor_angle_deg) return std::optional<FanFit>();
    if (frame.pose) poses.push_back(turned(*frame.pose, orientation, {sequence.columns, sequence.rows}));
  }
  if (poses.empty() || orientation.lines_in_rows) return std::optional<FanFit>();
  auto fit = fit_fan(poses, sequence.columns / 2.0);
  if (!fit) return Error{fit.error().code, fmt::format("{}: {}", shown(path), fit.error().message)};
  if (const std::string why = why_no_fan(*fit); !why.empty()) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{}: the poses of the frames form no fan: {}", shown(path), why)};
  }
  auto angle_rad = fit->angles_rad.begin();
  for (SequenceFrame& frame : sequence.frames) {
    if (frame.pose) frame.motor_angle_deg = degrees(*angle_rad++);
    frame.valid = frame.valid && frame.motor_angle_deg;
  }
  return std::optional(*std::move(fit));
}

Result<void> refuse_tracked_by_hand(const std::filesystem::path& path, const FrameSequence& sequence) {
  constexpr double kLeastMm = 1;
  constexpr double kLeastDeg = 0.5;
  if (std::ranges::any_of(sequence.frames,
                          [](const SequenceFrame& frame) { return frame.motor_angle_deg.has_value(); }))
    return {};
  for (const auto& [name, motion] : sequence.motions) {
    if (motion.most_mm < kLeastMm && motion.most_deg < kLeastDeg) continue;
    return Error{
        ErrorCode::kUnsupported,
        fmt::format("{}: the probe was moved, {:.0f} mm and {:.0f} deg far by its {}, and did not turn "
                    "about an axis: no fan, expected frames of a motor, with a MotorAngleDeg each",
                    shown(path), motion.most_mm, motion.most_deg, name)};
  }
  return {};
}

}  // namespace fanlight
