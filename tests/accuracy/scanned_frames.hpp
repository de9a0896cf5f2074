// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>

#include "proto/model/volume.hpp"
#include "tests/accuracy/test_fans.hpp"
#include "tests/support/known_surface.hpp"
#include "tests/support/scanner_echo.hpp"
#include "tests/support/speckle_field.hpp"

namespace fanlight::test {

/// A scanner, as far as its pictures differ from another one's.
struct Scanner {
  const char* name;
  ScannerEcho echo;
};
/// A usual one, one with a wide range, and one with a broad beam.
std::span<const Scanner> scanners();

/// What the echo is made of: the share of tissue at a place. See ScannerEcho.
using Share = std::function<double(const glm::dvec3& at, const BeamAxes& axes, double depth_mm)>;

/// What is random in the pictures of a fan. It takes as long to make as all else of a volume, and is shared
/// by all scanners and surfaces.
struct Grains {
  Grains(const TestFan& fan, std::uint64_t seed)
      : speckle(speckle_of(fan, seed)),
        noise({.columns = fan.geometry.columns,
               .rows = fan.geometry.rows,
               .frames = static_cast<std::uint32_t>(fan.angles_rad.size())},
              {.columns = 0.5, .rows = 1, .frames = 0.5}, seed + 1) {}

  SpeckleField speckle;
  SpeckleField noise;  ///< the receiver's, new in each sample
};

/// A sweep as the scanner shows it.
Volume scanned(const TestFan& fan, const Share& share, const ScannerEcho& echo, const Grains& grains);

/// The same of a surface, below which is tissue.
Volume scanned(const TestFan& fan, const KnownSurface& surface, const ScannerEcho& echo,
               const Grains& grains);

}  // namespace fanlight::test
