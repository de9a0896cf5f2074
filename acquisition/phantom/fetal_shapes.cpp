// SPDX-License-Identifier: Apache-2.0
// The smooth unions are the polynomial ones, and the distance to an ellipsoid the usual bound, both as in
// I. Quilez, "Distance functions" and "Smooth minimum", iquilezles.org.
#include "acquisition/phantom/fetal_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <span>

namespace fanlight {

namespace {

using glm::vec2;
using glm::vec3;

/// The union of two bodies; where both are nearer than `width_mm`, the seam between them is filled.
float joined(float a_mm, float b_mm, float width_mm) {
  const float overlap = std::max(width_mm - std::abs(a_mm - b_mm), 0.0F) / width_mm;
  return std::min(a_mm, b_mm) - overlap * overlap * width_mm / 4;
}

/// The first body without the second one, with a rounded edge.
float without(float body_mm, float cut_mm, float width_mm) {
  return -joined(-body_mm, cut_mm, width_mm);
}

float ellipsoid(const vec3& at, const vec3& centre, const vec3& half_axes) {
  const vec3 scaled = (at - centre) / half_axes;
  const float length = glm::length(scaled);
  const float slope = glm::length(scaled / half_axes);
  const float shortest = std::min({half_axes.x, half_axes.y, half_axes.z});
  return slope < 1e-6F ? -shortest : length * (length - 1) / slope;
}

/// Position of the nearest point of a line from a to b, 0 to 1.
template <typename Vector>
float nearest_share(const Vector& at, const Vector& a, const Vector& b) {
  return std::clamp(glm::dot(at - a, b - a) / glm::dot(b - a, b - a), 0.0F, 1.0F);
}

/// A rounded cone from a to b.
float limb(const vec3& at, const vec3& a, const vec3& b, float radius_a, float radius_b) {
  const float share = nearest_share(at, a, b);
  return glm::distance(at, a + share * (b - a)) - (radius_a + share * (radius_b - radius_a));
}

/// Rounded cones along a line of points, whose radius changes evenly from the first point to the last.
float bow(const vec3& at, std::span<const vec3> points, float first_radius, float last_radius) {
  float nearest = 1e9F;
  const auto parts = static_cast<float>(points.size() - 1);
  const auto radius = [&](std::size_t point) {
    return first_radius + (last_radius - first_radius) * static_cast<float>(point) / parts;
  };
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    nearest = std::min(nearest, limb(at, points[i], points[i + 1], radius(i), radius(i + 1)));
  return nearest;
}

/// A line engraved into the face from the front: points as (x, z).
float engraved(const vec3& at, std::span<const vec2> points, float width_mm, float depth_mm) {
  float nearest = 1e9F;
  const vec2 seen(at.x, at.z);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const vec2 on_line =
        points[i] + nearest_share(seen, points[i], points[i + 1]) * (points[i + 1] - points[i]);
    const vec2 away = seen - on_line;
    nearest = std::min(nearest, glm::dot(away, away));
  }
  return depth_mm * std::exp(-nearest / (2 * width_mm * width_mm));
}

/// An ear about the origin: x away from the head, y to the face, z up.
float ear(const vec3& at) {
  const vec3 upright(at.x, at.y + 0.25F * at.z, at.z);  // it leans back
  constexpr float kHeight = 1.45F;                      // of its width
  constexpr float kHalfWidthMm = 8.2F;
  const float around = std::atan2(upright.z / kHeight, upright.y);
  const float forward = std::cos(around);
  const vec3 on_rim(2.5F + 2.2F * std::max(0.0F, -forward), kHalfWidthMm * forward,
                    kHalfWidthMm * kHeight * std::sin(around));
  const float open = 14 * std::max(0.0F, forward - 0.75F);  // no rim next to the face
  const float rim = glm::distance(upright, on_rim) - 1.7F + open;
  float made = joined(rim, ellipsoid(upright, {0.6F, -0.8F, 0}, {2.2F, 8.2F, 11.5F}), 2);
  constexpr vec3 kFold[] = {
      {3.0F, -3.0F, 6.5F}, {3.4F, -4.0F, 2.0F}, {3.2F, -3.0F, -3.5F}, {2.8F, 0.5F, -6.0F}};
  made = joined(made, bow(upright, kFold, 1.2F, 1.3F), 1.5F);
  made = without(made, ellipsoid(upright, {3.0F, 0.5F, 1.0F}, {3.6F, 3.6F, 5.8F}), 1.5F);
  made = joined(made, ellipsoid(upright, {1.5F, 2.0F, -11.0F}, {2.2F, 3.2F, 3.6F}), 2.5F);  // lobe
  return joined(made, ellipsoid(upright, {1.8F, 5.2F, -1.5F}, {1.6F, 1.8F, 2.6F}), 1.5F);
}

float skull_and_cheeks(const vec3& at, const vec3& half) {
  float made = ellipsoid(at, {0, -12, 15}, {42, 53, 42});
  made = joined(made, ellipsoid(at, {0, 13, 20}, {33, 29, 26}), 18);        // forehead
  made = joined(made, ellipsoid(at, {0, 8, -12}, {33, 33, 34}), 14);        // face
  made = joined(made, ellipsoid(half, {19, 24, -15}, {15, 14.5F, 14}), 9);  // cheeks
  made = joined(made, ellipsoid(at, {0, 28, -22}, {13, 13, 11}), 9);        // about the mouth
  made = joined(made, ellipsoid(at, {0, 31, -36.5F}, {9.5F, 8.5F, 7}), 8);  // chin
  return joined(made, ellipsoid(at, {0, 10, -36}, {21, 23, 10}), 10);       // below the jaw
}

float with_eyes(float made, const vec3& half) {
  constexpr vec3 kBrow[] = {{5, 37.2F, 10.5F}, {13, 37.6F, 13}, {22, 33, 12}, {28, 26, 8}};
  made = joined(made, bow(half, kBrow, 3.0F, 2.8F), 8);
  made = without(made, ellipsoid(half, {15.5F, 44.5F, 2.5F}, {10.5F, 8, 6.5F}), 8);      // sockets
  made = joined(made, ellipsoid(half, {15.3F, 31.0F, 0.8F}, {9.6F, 8.9F, 7.8F}), 3.0F);  // closed lids
  return joined(made, ellipsoid(half, {15.5F, 33.0F, -7.0F}, {8, 4, 2.8F}), 5);          // below them
}

float with_nose(float made, const vec3& at, const vec3& half) {
  made = joined(made, limb(at, {0, 36, 7}, {0, 43.5F, -7.5F}, 3.4F, 4.6F), 8);
  made = joined(made, ellipsoid(at, {0, 45.2F, -9.0F}, {5.6F, 5.4F, 4.9F}), 3.5F);
  made = joined(made, ellipsoid(half, {6.3F, 41.4F, -10.6F}, {3.9F, 4.6F, 3.7F}), 2.4F);
  return without(made, ellipsoid(half, {3.1F, 45.4F, -14.0F}, {1.8F, 2.6F, 2.0F}), 1.4F);
}

float with_lips(float made, const vec3& at, const vec3& half) {
  constexpr vec3 kUpper[] = {
      {0, 43.0F, -21.0F}, {3.0F, 43.2F, -20.2F}, {6.2F, 40.9F, -21.4F}, {9.6F, 37.4F, -23.2F}};
  made = joined(made, bow(half, kUpper, 2.6F, 1.3F), 2.8F);
  return joined(made, ellipsoid(at, {0, 40.3F, -26.7F}, {7.4F, 4.4F, 3.3F}), 2.8F);
}

/// What the lines of the face take away.
float lines_of_face(const vec3& half) {
  constexpr vec2 kLids[] = {{7.0F, 0.6F}, {9, -1.4F},     {12, -3.0F},  {15.5F, -3.6F},
                            {19, -3.0F},  {22.3F, -1.2F}, {24.5F, 1.2F}};
  constexpr vec2 kUpperLid[] = {{8.0F, 4.6F}, {11, 6.8F}, {15.5F, 7.6F}, {20, 6.8F}, {23.5F, 4.0F}};
  constexpr vec2 kMouth[] = {{0, -23.5F}, {3, -23.1F}, {6.5F, -23.4F}, {9.8F, -24.4F}};
  constexpr vec2 kCorner[] = {{9.8F, -24.4F}, {11.0F, -25.4F}};
  constexpr vec2 kPhiltrum[] = {{0, -15.5F}, {0, -18.6F}};
  constexpr vec2 kCheek[] = {{8.5F, -11.5F}, {12.0F, -17}, {14.2F, -23}};
  constexpr vec2 kBelowLip[] = {{0, -31.3F}, {6, -30.8F}};
  const float front = std::clamp((half.y - 15) / 10, 0.0F, 1.0F);
  return front * (engraved(half, kLids, 0.75F, 1.5F) + engraved(half, kUpperLid, 1.1F, 0.7F) +
                  engraved(half, kMouth, 0.9F, 1.5F) + engraved(half, kCorner, 1.5F, 1.3F) +
                  engraved(half, kPhiltrum, 1.5F, 1.3F) + engraved(half, kCheek, 2.2F, 1.2F) +
                  engraved(half, kBelowLip, 2.0F, 1.6F));
}

struct Finger {
  float base_x;
  float first_mm;  // length of its first bone
};

/// A finger of three bones, bent towards the palm.
float finger(const vec3& at, const Finger& of, float bend_rad) {
  const auto bone = [](const vec3& from, float x, float length_mm, float angle_rad) {
    return vec3(x, from.y - length_mm * std::sin(angle_rad), from.z + length_mm * std::cos(angle_rad));
  };
  const vec3 knuckle(of.base_x, 0.8F, 10 - 0.015F * of.base_x * of.base_x);
  const vec3 second = bone(knuckle, 1.3F * of.base_x, of.first_mm, bend_rad);
  const vec3 third = bone(second, 1.5F * of.base_x, 0.62F * of.first_mm, 1.75F * bend_rad + 0.25F);
  const vec3 tip = bone(third, 1.6F * of.base_x, 0.42F * of.first_mm, 2.25F * bend_rad + 0.35F);
  float made = limb(at, knuckle, second, 3.3F, 2.8F);
  made = joined(made, limb(at, second, third, 2.8F, 2.6F), 1);
  return joined(made, limb(at, third, tip, 2.6F, 2.3F), 1);
}

}  // namespace

float fetal_head_mm(const vec3& at_mm) {
  const vec3 half(std::abs(at_mm.x), at_mm.y, at_mm.z);  // both sides are the same
  float made = skull_and_cheeks(at_mm, half);
  made = with_eyes(made, half);
  made = with_nose(made, at_mm, half);
  made = with_lips(made, at_mm, half) + lines_of_face(half);
  made = joined(made, ear(half - vec3(36.5F, -10, -1)), 2);
  made = joined(made, limb(at_mm, {0, -6, -30}, {0, -14, -75}, 20, 23), 12);   // neck
  return joined(made, limb(half, {0, -12, -84}, {46, -14, -90}, 24, 19), 14);  // shoulders
}

float fetal_hand_mm(const vec3& at_mm) {
  constexpr Finger kFingers[] = {{-9.9F, 10.5F}, {-3.4F, 13}, {3.2F, 13.5F}, {9.6F, 12}};
  float made = ellipsoid(at_mm, {0, 0, 0}, {12.5F, 6, 13});
  made = joined(made, limb(at_mm, {0, 0, -8}, {2, -4, -60}, 8.5F, 12), 8);  // forearm
  float bend_rad = 0.53F;
  float fingers = 1e9F;
  for (const Finger& each : kFingers) {
    fingers = std::min(fingers, finger(at_mm, each, bend_rad));
    bend_rad -= 0.04F;
  }
  made = joined(made, fingers, 2.2F);
  const float thumb = joined(limb(at_mm, {10, -2, -4}, {17, -5, 4}, 4.6F, 3.7F),
                             limb(at_mm, {17, -5, 4}, {18.5F, -8, 13}, 3.6F, 2.9F), 1.5F);
  return joined(made, thumb, 4);
}

float umbilical_cord_mm(const vec3& at_mm) {
  constexpr int kPoints = 260;
  constexpr float kRadiusMm = 3.6F;
  constexpr float kTwistRad = 26;
  float nearest = 1e9F;
  for (int point = 0; point <= kPoints; ++point) {
    const float share = static_cast<float>(point) / kPoints;
    const vec3 middle(-52 + 70 * share, 18 - 20 * share + 10 * std::sin(5 * share),
                      -55 - 18 * share + 10 * std::sin(3.1F * share));
    const float twist = kTwistRad * share;
    const vec3 strand(1.2F * std::sin(twist), 3.0F * std::sin(twist), 3.0F * std::cos(twist));
    nearest =
        std::min({nearest, glm::distance(at_mm, middle + strand), glm::distance(at_mm, middle - strand)});
  }
  return nearest - kRadiusMm;
}

}  // namespace fanlight
