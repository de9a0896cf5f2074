// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "acquisition/phantom/distance_grid.hpp"

namespace fanlight {

/// Bodies in fluid within the wall of a uterus, as signed distances to their common surface: positive in
/// fluid. In the transducer frame, mm.
///
/// kFace: a fetal head in three-quarter view, a hand at its cheek and the umbilical cord, about 55 to 150
/// mm deep. It breathes, turns and moves the hand with periods of some seconds. kSphere: of 30 mm radius, 90
/// mm deep in the middle. kPlane: tissue from 90 mm on, tilted by 20 deg.
///
/// Immutable after construction: any thread may read it.
class BodyScene {
 public:
  enum class Kind : std::uint8_t { kFace, kSphere, kPlane };
  static constexpr std::size_t kMostBodies = 3;
  static constexpr float kNearMm = 22;

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

  /// What lies at a point.
  struct Found {
    float distance_mm = 0;
    bool has_bone = false;  ///< the nearest body has bones below its skin
  };

  /// Takes most of a second for the face, once in a process.
  BodyScene(Kind kind, bool moving);

  Poses poses_at(double time_s) const;

  /// The line in the frames of all bodies; given in the transducer frame, `along` of length 1.
  Lines in_bodies(const Poses& poses, const Line& line) const;

  /// `across_mm`: within 10 mm of the line. Distances above 12 mm may be called 12 mm.
  Found at(const Lines& lines, float along_mm, float across_mm) const;

  /// The signed distance to the nearest surface. Truth for tests.
  float distance_mm(const Poses& poses, const glm::vec3& at_mm) const;

 private:
  struct Body {
    std::shared_ptr<const DistanceGrid> surface;
    bool has_bone = false;
  };

  Kind kind_;
  bool moving_;
  std::vector<Body> bodies_;
};

}  // namespace fanlight
