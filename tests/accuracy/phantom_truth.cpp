// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/phantom_truth.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fanlight::test {

double ReliefSurface::below_mm(const glm::dvec3& at) const {
  constexpr double kReachMm = 0.25;
  const double by_x = (surface_mm(at.x + kReachMm, at.z) - surface_mm(at.x - kReachMm, at.z)) / kReachMm;
  const double by_z = (surface_mm(at.x, at.z + kReachMm) - surface_mm(at.x, at.z - kReachMm)) / kReachMm;
  return (at.y - surface_mm(at.x, at.z)) / std::sqrt(1 + (by_x * by_x + by_z * by_z) / 4);
}

std::optional<double> ReliefSurface::entry_mm(const PixelRay& ray, double from_mm, double to_mm) const {
  const bool along_depth = std::abs(ray.direction.x) < 1e-12 && std::abs(ray.direction.z) < 1e-12;
  if (!along_depth) return KnownSurface::entry_mm(ray, from_mm, to_mm);
  const double depth_mm = surface_mm(ray.origin.x, ray.origin.z) - ray.origin.y;
  return depth_mm >= from_mm && depth_mm <= to_mm ? std::optional(depth_mm) : std::nullopt;
}

double BodySurface::below_mm(const glm::dvec3& at) const {
  return -static_cast<double>(scene_.distance_mm(poses_, at));
}

std::optional<double> BodySurface::entry_mm(const PixelRay& ray, double from_mm, double to_mm) const {
  // Steps that do not cross the surface; a groove's walls are steeper than the distance tells.
  constexpr double kSafe = 0.6;
  constexpr double kLeastMm = 0.02;
  bool in_fluid = below_mm(ray.at(from_mm)) <= 0;
  for (double depth_mm = from_mm; depth_mm < to_mm;) {
    const double below = below_mm(ray.at(depth_mm));
    if (in_fluid && below > 0) return depth_mm - kLeastMm / 2;
    in_fluid = below <= 0;
    depth_mm += std::max(kLeastMm, kSafe * std::abs(below));
  }
  return std::nullopt;
}

std::unique_ptr<PhantomSource> made_phantom(const PhantomSource::Config& config) {
  auto source = PhantomSource::create(config);
  if (!source) throw std::runtime_error(source.error().message);
  return std::move(*source);
}

std::unique_ptr<KnownSurface> surface_of(const PhantomSource& source, double time_s) {
  if (source.bodies() != nullptr) return std::make_unique<BodySurface>(*source.bodies(), time_s);
  return std::make_unique<ReliefSurface>(source.scene());
}

Volume next_sweep(PhantomSource& source) {
  const SourceDescription& description = source.description();
  Volume volume(description.geometry, description.frames_per_volume);
  while (!volume.full()) {
    const auto frame = source.next_frame({});
    if (!frame || !*frame) throw std::runtime_error("the simulated probe has ended within a sweep");
    source.read_pixels(volume.next_frame_pixels(), {});
    volume.add_frame(**frame);
  }
  volume.sort_by_angle();
  volume.stamp().volume_id = 1;
  return volume;
}

}  // namespace fanlight::test
