// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

namespace fanlight {

// The sculpted parts of the simulated probe's face, as signed distances (DistanceGrid::Shape): unions and
// cuts of ellipsoids and rounded cones with smooth transitions, and lines engraved from the front. mm.

/// A fetal head with neck and shoulders, in the last third of a pregnancy. Its own frame: x to the left of
/// who looks at it, y out of the face, z up; the origin lies between the ears. The tip of the nose is at (0,
/// 51, -9), the top at z = 57, the chin at z = -43.
float fetal_head_mm(const glm::vec3& at_mm);

/// A hand with its forearm. Its own frame, left-handed too: x to the thumb, y out of the back of the hand, z
/// to the tips of the fingers; the origin lies in the middle of the palm. The fingers end at about z = 38.
float fetal_hand_mm(const glm::vec3& at_mm);

/// A part of the umbilical cord: two strands about each other. In the frame of the head.
float umbilical_cord_mm(const glm::vec3& at_mm);

}  // namespace fanlight
