// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "proto/model/volume.hpp"
#include "tests/support/known_surface.hpp"
#include "tests/support/scanned_fan.hpp"
#include "tests/support/speckle_field.hpp"

namespace fanlight::test {

/// Depth of the surfaces in the small fans, mm.
inline constexpr double kSurfaceDepthMm = 32;

/// A sweep of one kind of frames, sampled at about 0.31 mm in each direction at the surfaces' depth.
struct TestFan {
  std::string name;
  FanGeometry geometry;
  std::vector<double> angles_rad;  ///< in order of acquisition

  ScannedFan scanned() const;
};

/// Cartesian frames at even angles; convex lines at uneven angles; linear lines at uneven angles, in a
/// backward sweep.
std::vector<TestFan> test_fans();

struct TestSurface {
  std::string name;
  std::unique_ptr<KnownSurface> surface;
};

/// Planes, named by their rotations about x and z in degrees, a sphere that just fits into the pictures, and
/// a relief.
std::vector<TestSurface> test_surfaces();

/// Speckle for a fan, with grains of 0.5 mm along the lines, 1 mm across and 2 mm in elevation at the depth
/// of the surfaces.
SpeckleField speckle_of(const TestFan& fan, std::uint64_t seed);

/// Draws the pixels of a frame, rows x columns. `place`: of the frame in order of angle, from 0.
using DrawFrame = std::function<void(std::uint32_t place, double angle_rad, std::span<std::uint8_t> pixels)>;

/// A sweep whose frames are drawn by several threads at once.
Volume swept(const TestFan& fan, const DrawFrame& draw);

/// A sweep over a known surface, 8 bit. `speckle`: nullptr for none.
Volume swept(const TestFan& fan, const KnownSurface& surface, const KnownEcho& echo,
             const SpeckleField* speckle);

}  // namespace fanlight::test
