// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "acquisition/phantom/body_scene.hpp"

namespace fanlight {

/// The echoes of a BodyScene along one scan line, as a beam with a thickness across the frame (elevation)
/// receives them:
/// - The beam is narrowest at its focus. Its echo is the mean power of five neighbouring lines across the
///   frame, with Gaussian weights.
/// - The pulse has a length: the power is blurred along the line.
/// - Skin is bright where the line meets it at a right angle, and fainter where it grazes. Tissue scatters;
///   bone below the skin of the head and the hand is bright.
/// - Tissue weakens what comes from behind it by more than the gain by depth makes up for, and bone takes
///   almost all of it: behind the hand and within the head it is dark. Below that is the receiver's noise.
///
/// One thread; allocates nothing after construction.
class BeamEcho {
 public:
  /// A beam's thickness is that between the points where the amplitude of its echo is half of the middle's
  /// (-6 dB), as data sheets give it. For a Gaussian, the power's standard deviation is 1 / (4 sqrt(ln 2)) of
  /// that.
  static constexpr double kDeviationOfBeam = 0.300280;
  /// Standard deviation of the pulse's power along the line, mm.
  static constexpr float kPulseMm = 0.2F;

  /// `beam_mm`: thickness at the focus, see kDeviationOfBeam. 0: a line.
  explicit BeamEcho(double beam_mm);

  /// Standard deviation of the beam's power across the frame.
  float deviation_mm(float depth_mm) const;

  /// Power of the reverberation at a distance from the probe's face, in the unit of draw(), which leaves it
  /// out. 0 from kReverberationMm on.
  static float reverberation(float depth_mm);
  static constexpr float kReverberationMm = 22;

  /// Samples of a line, from first_mm along it, step_mm apart.
  struct Samples {
    float first_mm = 0;
    float step_mm = 0;
    float face_mm = 0;  ///< where the line leaves the probe
  };

  /// Writes the mean power of the echo at each sample, in squared units of EchoScale::kTissue.
  void draw(const BodyScene& scene, const BodyScene::Lines& lines, const Samples& samples,
            std::span<float> power) const;

 private:
  static constexpr std::size_t kAcross = 5;

  void draw_echoes(const BodyScene& scene, const BodyScene::Lines& lines, const Samples& samples,
                   std::span<float> power) const;

  float focus_deviation_mm_;
  std::array<float, kAcross> weights_{};
};

}  // namespace fanlight
