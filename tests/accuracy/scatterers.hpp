// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "proto/model/volume.hpp"
#include "tests/accuracy/test_fans.hpp"
#include "tests/support/known_surface.hpp"
#include "tests/support/scanner_echo.hpp"
#include "tests/support/speckle_field.hpp"

namespace fanlight::test {

/// Point scatterers that belong to a body: it shows the same speckle again wherever it is carried, as far as
/// the beam meets it alike. Echoes add with their phases.
class Scatterers {
 public:
  /// At random within the fan, below the surface, some nine in a cell of the beam's resolution.
  Scatterers(const TestFan& fan, const KnownSurface& surface, std::uint64_t seed);

  /// From where a point of the body was to where it is.
  using Move = std::function<glm::dvec3(const glm::dvec3& at)>;

  /// A sweep as the scanner shows it, with the noise of its receiver. Without side lobes.
  Volume scanned(const Move& move, const ScannerEcho& echo, const SpeckleField& noise) const;

 private:
  struct Scatterer {
    glm::dvec3 at{};
    float amplitude = 0;
  };
  const TestFan& fan_;
  std::vector<Scatterer> scatterers_;
};

}  // namespace fanlight::test
