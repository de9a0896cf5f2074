// SPDX-License-Identifier: Apache-2.0
// CPU twin of shaders/frame_steps.comp (renderer/ALGORITHM.md, pass 1), in double precision.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/pixel_rays.hpp"
#include "tests/support/twin_echo.hpp"
#include "tests/support/twin_map.hpp"

namespace fanlight::test {

namespace {

using glm::dvec2;
using glm::ivec2;

class SmoothAcrossFrames {
 public:
  SmoothAcrossFrames(const Scene& scene, PictureSize size, const Volume& prepared,
                     const std::vector<double>& ray_mm)
      : prepared_(prepared), rays_(scene, size), port_(rays_.port()), map_(ray_mm, size, port_) {
    const auto order = prepared.by_angle();
    const auto angles_rad = prepared.angles_rad();
    const double intervals = std::max(static_cast<double>(order.size()) - 1, 1.0);
    frame_angle_rad_ = (angles_rad[order.back()] - angles_rad[order.front()]) / intervals;
  }

  std::vector<double> depths_mm(const std::vector<double>& ray_mm) const {
    std::vector<double> smooth_mm = ray_mm;
    map_.for_each([&](int column, int row) {
      if (map_.surface(column, row)) smooth_mm[map_.index(column, row)] = mean_mm({column, row});
    });
    return smooth_mm;
  }

 private:
  double depth_mm(ivec2 pixel) const { return map_.depth(pixel.x, pixel.y); }

  glm::dvec3 point(ivec2 pixel, double depth_mm) const {
    return rays_.ray(static_cast<std::uint32_t>(pixel.x), static_cast<std::uint32_t>(pixel.y)).at(depth_mm);
  }

  double frame(ivec2 pixel, double depth_mm) const {
    const glm::dvec3 at = point(pixel, depth_mm);
    const double angle_rad = std::atan2(at.z, at.y + prepared_.geometry().motor_radius_mm);
    const auto known = frame_coordinate(prepared_, angle_rad);
    // Rounding may put a surface on the first or last frame beyond it.
    return known ? *known : angle_rad < 0 ? 0 : static_cast<double>(prepared_.by_angle().size()) - 1;
  }

  double mean_mm(ivec2 pixel) const {
    const double here_mm = depth_mm(pixel);
    const glm::dvec3 at = point(pixel, here_mm);
    const double spacing_mm =
        frame_angle_rad_ * std::hypot(at.y + prepared_.geometry().motor_radius_mm, at.z);
    const double pixel_mm = glm::length(point(pixel + ivec2(1, 0), here_mm) - at);
    const double pixels = spacing_mm / pixel_mm;
    const auto same_surface = [&](double there_mm) {
      return there_mm >= 0 && std::abs(there_mm - here_mm) < 4 * spacing_mm;
    };

    const int base = static_cast<int>(std::clamp(std::floor(0.7 * pixels + 0.5), 1.0, 8192.0));
    const double frame_here = frame(pixel, here_mm);
    const auto change = [&](ivec2 direction) {
      double sum = 0;
      int sides = 0;
      for (const int side : {-1, 1}) {
        const ivec2 there = pixel + side * base * direction;
        if (!same_surface(depth_mm(there))) continue;
        sum += side * (frame(there, depth_mm(there)) - frame_here);
        ++sides;
      }
      return sum / (std::max(sides, 1) * base);
    };
    const dvec2 changes(change({1, 0}), change({0, 1}));
    const double steepest = glm::length(changes);
    const double share = std::clamp((steepest * pixels - 0.25) / 0.15, 0.0, 1.0);
    if (share == 0) return here_mm;

    const dvec2 whole_mean = std::min(1 / steepest, 3 * pixels) / steepest * changes;
    double sum = 0;
    int count = 0;
    for (const double part : {0.05, 0.15, 0.25, 0.35, 0.45}) {
      const ivec2 shift(glm::floor(part * whole_mean + 0.5));
      const double before_mm = depth_mm(pixel - shift);
      const double after_mm = depth_mm(pixel + shift);
      if (!same_surface(before_mm) || !same_surface(after_mm)) continue;
      sum += before_mm + after_mm;
      count += 2;
    }
    return count > 0 ? std::lerp(here_mm, sum / count, share) : here_mm;
  }

  const Volume& prepared_;
  PixelRays rays_;
  Viewport port_;
  TwinMap map_;
  double frame_angle_rad_ = 0;
};

}  // namespace

std::vector<double> twin_frame_steps(const Scene& scene, PictureSize size, const Volume& prepared,
                                     const std::vector<double>& ray_mm) {
  return SmoothAcrossFrames(scene, size, prepared, ray_mm).depths_mm(ray_mm);
}

}  // namespace fanlight::test
