// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/known_surface.hpp"

namespace fanlight::test {

/// Directions of a frame's pixel in the transducer frame, unit vectors.
struct BeamAxes {
  glm::dvec3 axial{};      ///< along the scan line
  glm::dvec3 lateral{};    ///< across it, in the frame
  glm::dvec3 elevation{};  ///< across the frame
};

/// Grey levels as a scanner makes them: the amplitude of the echo is blurred by the pulse and by the beam;
/// what the side lobes meet and the reverberation below the probe are added to its power; the speckle
/// multiplies it, the receiver adds its noise, and then it is log-compressed. The blur of a
/// surface is that of a plane through its normal: exact for planes, and where the radius of curvature is
/// large against the beam.
struct ScannerEcho {
  double range_db = 60;      ///< from black to white
  double tissue_grey = 190;  ///< mean echo of tissue
  double contrast_db = 40;   ///< of tissue over fluid
  double noise_db = -52;     ///< of the receiver, over tissue
  /// Scatterers without order, as in tissue: their powers add, so the power is blurred, by the square of the
  /// point spread. False: the amplitude is blurred, as of a smooth border.
  bool is_diffuse = false;
  double thickness_mm =
      0;  ///< full width at half maximum of a bright sheet in fluid; 0: tissue fills what is below

  // Standard deviations of the amplitude's point spread.
  double axial_mm = 0.2;
  double lateral_mm = 0.5;    ///< at the focus
  double elevation_mm = 0.9;  ///< at the focus
  double focus_mm = 32;
  double widening = 0.02;  ///< of both, mm a mm from the focus

  double lobes_db = -32;               ///< of all side lobes, over the echo of what they meet
  double reverberation_db = 0;         ///< at the probe's face, over tissue
  double reverberation_db_per_mm = 4;  ///< by which it falls

  /// The largest standard deviation of the amplitude's point spread, in any direction.
  double widest_mm(double depth_mm) const;

  /// Amplitude of the blurred echo, 0 for fluid to 1 for tissue.
  double share(double below_mm, const glm::dvec3& normal, const BeamAxes& axes, double depth_mm) const;

  /// `share`: see above. `beside`: mean square of the share where the side lobes point. `depth_mm`: from the
  /// probe's face. `factor`, `noise`: of speckle, with mean 1.
  double grey(double share, double beside, double depth_mm, double factor, double noise) const;

 private:
  double spread_mm(const glm::dvec3& normal, const BeamAxes& axes, double depth_mm) const;
};

}  // namespace fanlight::test
