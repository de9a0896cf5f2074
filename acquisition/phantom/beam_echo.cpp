// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/beam_echo.hpp"

#include <algorithm>
#include <cmath>

#include "acquisition/phantom/echo_scale.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr float kTissue = static_cast<float>(EchoScale::kTissue);
// Fluid is 34 dB below tissue, skin at a right angle 7 dB above it, bone 10 dB above. The receiver's noise is
// 40 dB below tissue.
constexpr float kFluidPower = 2.2F * 2.2F;
constexpr float kTissuePower = kTissue * kTissue;
constexpr float kSkinPower = 5.0F * kTissuePower;
constexpr float kBonePower = 10.0F * kTissuePower;
constexpr float kNoisePower = 1e-4F * kTissuePower;

constexpr float kHalfStepMm = 0.25F;  // half width of the step at the surface, less than a pixel
constexpr float kSkinLineMm = 0.7F;   // middle of the skin's bright line, and its standard deviation
constexpr float kBoneMm = 5.5F;       // middle of the bone's, and its standard deviation
constexpr float kBoneSpreadMm = 0.9F;
constexpr float kBoneEndMm = 7;

// Powers of two that 1 mm takes away, there and back, beyond the gain by depth.
constexpr float kTissueLoss = 0.04F;
constexpr float kBoneLoss = 2.2F;

constexpr float kFocusMm = 70;
constexpr float kWidening = 1.2F / 60;  // standard deviations at the focus that 1 mm beyond it adds

// Reverberation: about as loud as tissue at the face, 22 dB less 10 mm below it, with rings of +1.3 and -1.9
// dB. So it falls below the fluid within 16 mm.
constexpr float kReverberationHalfMm = 1.4F;
constexpr float kRingMm = 2.4F;
constexpr float kRingShare = 0.35F;

// Lines across the frame, in standard deviations of the beam.
constexpr std::array<float, 5> kPlaces = {-1.4F, -0.7F, 0, 0.7F, 1.4F};

float bell(float away) {
  return std::abs(away) < 4 ? std::exp(-0.5F * away * away) : 0.0F;
}

/// Power of the echo from a depth below the skin, before losses. `facing`: 0 to 1, how squarely the line
/// meets the skin. `tissue`: Found::echo.
float power_at(float depth_mm, float facing, bool has_bone, float tissue) {
  if (depth_mm < -kHalfStepMm) return kFluidPower;
  const float share = std::clamp(0.5F + 0.5F * depth_mm / kHalfStepMm, 0.0F, 1.0F);
  const float squareness = 0.15F + 0.85F * facing * facing;
  float power =
      tissue * kTissuePower + kSkinPower * squareness * bell((depth_mm - kSkinLineMm) / kSkinLineMm);
  if (has_bone) power += kBonePower * squareness * bell((depth_mm - kBoneMm) / kBoneSpreadMm);
  return kFluidPower + share * (power - kFluidPower);
}

/// By means of three samples, as often as their variances add up to the pulse's.
void blur_by_pulse(std::span<float> power, float step_mm) {
  constexpr float kMostShare = 0.25F;
  const float share = 0.5F * BeamEcho::kPulseMm * BeamEcho::kPulseMm / (step_mm * step_mm);
  const int rounds = static_cast<int>(std::ceil(share / kMostShare));
  const float of_each = share / static_cast<float>(rounds);
  for (int round = 0; round < rounds; ++round) {
    float before = power.front();
    for (std::size_t sample = 0; sample + 1 < power.size(); ++sample) {
      const float here = power[sample];
      power[sample] += of_each * (before + power[sample + 1] - 2 * here);
      before = here;
    }
  }
}

}  // namespace

BeamEcho::BeamEcho(double beam_mm) : focus_deviation_mm_(static_cast<float>(beam_mm * kDeviationOfBeam)) {
  float sum = 0;
  for (std::size_t line = 0; line < kAcross; ++line) sum += weights_[line] = bell(kPlaces[line]);
  for (float& weight : weights_) weight /= sum;
}

float BeamEcho::reverberation(float depth_mm) {
  if (depth_mm > kReverberationMm) return 0;
  const float ring = std::cos(2 * static_cast<float>(kPi) * depth_mm / kRingMm);
  return kTissuePower * std::exp2(-depth_mm / kReverberationHalfMm) * (1 + kRingShare * ring);
}

float BeamEcho::deviation_mm(float depth_mm) const {
  const float beyond = kWidening * (depth_mm - kFocusMm);
  return focus_deviation_mm_ * std::sqrt(1 + beyond * beyond);
}

void BeamEcho::draw(const BodyScene& scene, const BodyScene::Lines& lines, const Samples& samples,
                    std::span<float> power) const {
  draw_echoes(scene, lines, samples, power);
  blur_by_pulse(power, samples.step_mm);
}

void BeamEcho::draw_echoes(const BodyScene& scene, const BodyScene::Lines& lines, const Samples& samples,
                           std::span<float> power) const {
  float left = 1;  // of the power that was sent
  float before_mm = 0;
  for (std::size_t sample = 0; sample < power.size();) {
    const float along_mm = samples.first_mm + static_cast<float>(sample) * samples.step_mm;
    const BodyScene::Found found = scene.at(lines, along_mm, 0);
    const float deviation = deviation_mm(along_mm - samples.face_mm);
    const float reach_mm = 1.4F * deviation + kHalfStepMm;
    // Far from the surface all lines of the beam see the same for this many samples. Near engraved lines and
    // smooth seams the surface is nearer than the distance says.
    constexpr float kSafe = 0.6F;
    const float alike_mm = kSafe * std::abs(found.distance_mm) - reach_mm -
                           (found.distance_mm > 0 ? 0.0F : kSafe * (kBoneEndMm + 2));
    const bool has_layers = found.part == BodyScene::Part::kNearWall && found.distance_mm <= 0;
    if (alike_mm > samples.step_mm && !has_layers) {
      const auto steps = static_cast<std::size_t>(alike_mm / samples.step_mm);
      const std::size_t end = std::min(power.size(), sample + std::max<std::size_t>(steps, 1));
      const bool fluid = found.distance_mm > 0;
      const float loss = fluid ? 1.0F : std::exp2(-kTissueLoss * samples.step_mm);
      for (; sample < end; ++sample) {
        power[sample] = left * (fluid ? kFluidPower : kTissuePower) + kNoisePower;
        left *= loss;
      }
      before_mm = found.distance_mm;
      continue;
    }
    const float facing = std::clamp((before_mm - found.distance_mm) / samples.step_mm, 0.0F, 1.0F);
    before_mm = found.distance_mm;
    float mean = 0;
    float bone_share = 0;
    float tissue_share = 0;
    // Between three lines the distance is taken for a parabola.
    const float last_mm = kPlaces[kAcross - 1] * deviation;
    const float before_frame_mm = scene.at(lines, along_mm, -last_mm).distance_mm;
    const float behind_frame_mm = scene.at(lines, along_mm, last_mm).distance_mm;
    const float slope = 0.5F * (behind_frame_mm - before_frame_mm);
    const float bend = 0.5F * (behind_frame_mm + before_frame_mm) - found.distance_mm;
    for (std::size_t line = 0; line < kAcross; ++line) {
      const float place = kPlaces[line] / kPlaces[kAcross - 1];
      const float depth_mm = -(found.distance_mm + place * (slope + place * bend));
      mean += weights_[line] * power_at(depth_mm, facing, found.has_bone, found.echo);
      const bool in_bone = found.has_bone && depth_mm > kBoneMm - 1 && depth_mm < kBoneEndMm;
      bone_share += in_bone ? weights_[line] : 0.0F;
      tissue_share += depth_mm > 0 ? weights_[line] : 0.0F;
    }
    power[sample] = left * mean + kNoisePower;
    left *= std::exp2(-samples.step_mm * (kBoneLoss * bone_share + kTissueLoss * tissue_share));
    ++sample;
  }
}

}  // namespace fanlight
