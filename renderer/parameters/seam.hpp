// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer/parameters/steady_parameters.hpp"
#include "shaders/seam_parameters.h"

namespace fanlight {

/// The frames that have replaced those of the last sweep one by one (Refresh::kFrame). Does not allocate.
class NewFrames {
 public:
  void add(double angle_rad);
  /// How many there have been.
  std::uint64_t count() const { return count_; }
  /// Angles of the last ones, newest first: at most FANLIGHT_MOST_SEAM_FRAMES.
  std::span<const double> angles_rad() const { return std::span(angles_rad_).first(kept_); }
  /// Whether the motor has turned among them: some were replaced twice.
  bool turned() const;

 private:
  std::array<double, FANLIGHT_MOST_SEAM_FRAMES> angles_rad_{};
  std::size_t kept_ = 0;
  std::uint64_t count_ = 0;
};

/// Where the frames of a new sweep meet those of the last one, and the map that was shown before.
struct Seam {
  EarlierMap earlier;
  NewFrames frames;
  double frame_step_rad = 0;  ///< between neighbouring frames
  double motor_radius_mm = 0;
};

/// The share of the last sweep's surface that is left after a frame and `newer` further ones have come: from
/// just below 1 down to 0 after `seam_frames` (Scene::Filter), in equal steps.
double share_of_last_sweep(std::uint64_t newer, int seam_frames);

/// The uniforms of the seam for a map at `now`. `count_before`: NewFrames::count() of the map shown before.
shaders::SeamParameters seam_parameters(const MapPlace& now, const Seam& seam, int seam_frames,
                                        std::uint64_t count_before);

}  // namespace fanlight
