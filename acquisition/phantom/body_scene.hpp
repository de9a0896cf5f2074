// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "acquisition/phantom/distance_grid.hpp"

namespace fanlight {

/// Bodies in fluid within the wall of a uterus, as signed distances to their common surface: positive in
/// fluid. In the transducer frame, mm.
///
/// kFace: a fetal head in three-quarter view, a hand at its cheek and the umbilical cord, about 55 to 150
/// mm deep. It breathes, turns and moves the hand with periods of some seconds. kWomb: the same bodies,
/// turned and laid by the seed, behind an undulating near wall with a placenta of 8 to 30 mm; between its
/// inside and them lie 2 to 20 mm of fluid where it is the least. kSphere: of 30 mm radius, 90 mm deep in the
/// middle. kPlane: tissue from 90 mm on, tilted by 20 deg. kCyst: fluid in tissue, a sphere of 20 mm radius,
/// 75 mm deep in the middle.
///
/// Immutable after construction: any thread may read it.
class BodyScene {
 public:
  enum class Kind : std::uint8_t { kFace, kWomb, kSphere, kPlane, kCyst };
  static constexpr std::size_t kMostBodies = 3;
  static constexpr float kNearMm = 22;

  /// The inside of a sphere, which holds the fluid.
  struct FarWall {
    glm::vec3 middle_mm{0, 30, 0};
    float radius_mm = 122;
  };
  const FarWall& far_wall() const { return far_wall_; }

  /// From the transducer frame to the own frame of a body: turn * (point - origin). The bodies of the face
  /// are mirrored: their frames are left-handed.
  struct Pose {
    glm::mat3 turn{1};
    glm::vec3 origin_mm{0};
  };
  /// The bodies at one instant.
  using Poses = std::array<Pose, kMostBodies>;

  /// A straight line in the own frame of each body, and in that of the wall: `from + along_mm * along +
  /// across_mm * across`.
  struct Line {
    glm::vec3 from_mm{0};
    glm::vec3 along{0};
    glm::vec3 across{0};
    bool passes = true;  ///< comes within kNearMm of the body's box
  };
  using Lines = std::array<Line, kMostBodies + 1>;

  /// What the bodies are, and what they lie in.
  enum class Part : std::uint8_t { kFarWall, kNearWall, kHead, kHand, kCord, kShape };

  /// What lies at a point.
  struct Found {
    float distance_mm = 0;
    Part part = Part::kFarWall;  ///< the nearest
    bool has_bone = false;       ///< the nearest body has bones below its skin
    float echo = 1;              ///< power of the tissue there, of usual tissue's
  };

  /// Takes most of a second for the face, once in a process. `seed`: of the poses and of the near wall, and
  /// whether that is there; kWomb only.
  BodyScene(Kind kind, bool moving, std::uint64_t seed = 1, bool has_near_wall = true);

  Poses poses_at(double time_s) const;

  /// The line in the frames of all bodies; given in the transducer frame, `along` of length 1.
  Lines in_bodies(const Poses& poses, const Line& line) const;

  /// `across_mm`: within 10 mm of the line. Distances above 12 mm may be called 12 mm.
  Found at(const Lines& lines, float along_mm, float across_mm) const;

  /// The signed distance to the nearest surface. Truth for tests.
  float distance_mm(const Poses& poses, const glm::vec3& at_mm) const {
    return found(poses, at_mm).distance_mm;
  }
  Found found(const Poses& poses, const glm::vec3& at_mm) const;

  /// Least fluid between the near wall and the bodies along y, at time 0; kWomb only.
  float gap_mm() const { return gap_mm_; }

 private:
  struct Body {
    std::shared_ptr<const DistanceGrid> surface;
    Part part = Part::kShape;
    bool has_bone = false;
  };

  /// The near wall of kWomb, between the probe and its inside: as thick as the sum says, across the scan
  /// lines.
  struct NearWall {
    static constexpr std::size_t kWaves = 3;
    struct Wave {
      float across_per_mm = 0;  // rad, along x
      float up_per_mm = 0;      // rad, along z
      float phase_rad = 0;
      float amplitude_mm = 0;
    };
    float thickness_mm = 0;
    std::array<Wave, kWaves> waves{};
    // The placenta: a flat mound.
    glm::vec3 placenta_mm{0};  // x, z of its middle, and its height
    float placenta_radius_mm = 1;

    /// Below the probe's curved face, and where the wall ends there.
    struct Depth {
      float below_mm = 0;
      float end_mm = 0;
    };
    Depth depth(const glm::vec3& at_mm) const;
    /// Power of its tissue, of usual tissue's: skin, fat, muscles with their fasciae, uterus and placenta.
    static float echo(const Depth& depth);
  };

  /// How the bodies of kFace and kWomb lie at rest.
  struct Rest {
    double yaw_rad = 0.5;
    double pitch_rad = 0.12;
    double roll_rad = 0.1;
    glm::vec3 head_mm{0, 106, 2};  // the point between the ears
  };

  void lay_in_womb(std::uint64_t seed);
  float least_gap_mm() const;

  Kind kind_;
  bool moving_;
  Rest rest_;
  FarWall far_wall_;
  std::optional<NearWall> near_wall_;
  float gap_mm_ = 0;
  std::vector<Body> bodies_;
};

}  // namespace fanlight
