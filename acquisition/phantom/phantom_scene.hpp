// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fanlight {

/// Scene of the simulated probe: the face of a fetus in fluid, as a height field y = S(x, z, t) in the
/// transducer frame. It looks at the probe, the top of its head at +z. It spans about +-54 mm in x and +-59
/// mm in z, the tip of the nose at about 75 mm depth. It bobs, nods, turns, rolls and opens its mouth with
/// periods of several seconds; at time 0 it is already in motion.
///
/// Immutable after construction: any thread may read it.
class PhantomScene {
 public:
  enum class Motion : std::uint8_t { kMoving, kStill };

  /// Depth beyond any frame: fluid only, no face.
  static constexpr float kNoSurfaceMm = 1000.0F;

  /// Position of the face at one instant. Computed once per frame, because the motion functions are slow.
  struct Pose {
    double shift_x_mm = 0;
    double shift_y_mm = 0;
    double shift_z_mm = 0;
    double roll_cosine = 1;
    double roll_sine = 0;
    double turn_mm_per_mm = 0;  ///< depth added per mm to the face's left
    double nod_mm_per_mm = 0;   ///< depth added per mm up
    double mouth = 0;           ///< 0 closed to 1 open
  };

  /// Points of a row of pixels: point i lies at x = x_mm * across[i], z = z_mm + ahead_z_mm * ahead[i]. A
  /// straight row has ahead 0 everywhere; an arc uses the sines and cosines of its scan lines' angles.
  struct Row {
    std::span<const float> across;
    std::span<const float> ahead;
    double x_mm = 0;
    double z_mm = 0;
    double ahead_z_mm = 0;
  };

  explicit PhantomScene(Motion motion);

  Pose pose_at(double time_s) const;

  /// Depth y of the surface at (x, z). Beside the head: kNoSurfaceMm, or a depth near it that no frame
  /// reaches.
  double surface_depth_mm(double x_mm, double z_mm, double time_s) const;

  /// The same for each point of a row; writes as many as depths_mm holds. Allocates nothing.
  void surface_row_mm(const Pose& pose, const Row& row, std::span<float> depths_mm) const;

  /// Smallest depth of the surface over all times.
  double nearest_depth_mm() const { return nearest_depth_mm_; }

 private:
  struct Node {
    float relief_mm;  // depth of the closed face
    float mouth_mm;   // depth added by a fully open mouth
  };

  Motion motion_;
  std::vector<Node> nodes_;
  double nearest_depth_mm_ = 0;
};

}  // namespace fanlight
