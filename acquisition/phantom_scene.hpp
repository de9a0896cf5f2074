#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fanlight {

/// What the simulated probe looks at: the face of a fetus in fluid, as a height field y = S(x, z, t) in the
/// transducer frame, looking at the probe, the top of its head at +z. About +-54 mm in x and +-59 mm in z,
/// the tip of the nose some 75 mm deep. It bobs, nods, turns, rolls and opens its mouth with periods of
/// several seconds; at time 0 it is on the way.
///
/// Immutable after construction: any thread may read it.
class PhantomScene {
 public:
  enum class Motion : std::uint8_t { kMoving, kStill };

  /// Depth beyond any frame: there is no face, only fluid.
  static constexpr float kNoSurfaceMm = 1000.0F;

  /// Where the face is at one instant. Made once a frame, since it takes the slow functions of motion.
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

  /// The points of a row of pixels: point i lies at x = x_mm * across[i], z = z_mm + ahead_z_mm * ahead[i].
  /// A straight row has ahead 0 everywhere; an arc has the sines and cosines of its scan lines' angles.
  struct Row {
    std::span<const float> across;
    std::span<const float> ahead;
    double x_mm = 0;
    double z_mm = 0;
    double ahead_z_mm = 0;
  };

  explicit PhantomScene(Motion motion);

  Pose pose_at(double time_s) const;

  /// Depth y of the surface at (x, z); kNoSurfaceMm, or an unreachable depth near it, beside the head.
  double surface_depth_mm(double x_mm, double z_mm, double time_s) const;

  /// The same for each point of a row, as many as depths_mm has room for. Allocates nothing.
  void surface_row_mm(const Pose& pose, const Row& row, std::span<float> depths_mm) const;

  /// No surface lies nearer to the probe than this, whatever the time.
  double nearest_depth_mm() const { return nearest_depth_mm_; }

 private:
  struct Node {
    float relief_mm;  // depth of the closed face
    float mouth_mm;   // depth that a fully open mouth adds
  };

  Motion motion_;
  std::vector<Node> nodes_;
  double nearest_depth_mm_ = 0;
};

}  // namespace fanlight
