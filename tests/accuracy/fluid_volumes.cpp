// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <utility>

#include "renderer/survey/echo_survey.hpp"
#include "renderer/survey/fluid_region.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/scanned_frames.hpp"

namespace fanlight::test {

namespace {

constexpr char kFluidLegend[] =
    R"(Ellipsoids of fluid in tissue, in frames as a scanner makes them (see above), grown from a point beside their middle.
error: of the volume. plus-minus: the deviation that is given for it.)";

/// The inside of an ellipsoid is fluid.
class Cavity final : public KnownSurface {
 public:
  Cavity(const glm::dvec3& centre, const glm::dvec3& half_axes_mm) : centre_(centre), half_mm_(half_axes_mm) {}
  double below_mm(const glm::dvec3& at) const override {
    // Value over gradient: exact for spheres, and else at the surface.
    const glm::dvec3 scaled = (at - centre_) / half_mm_;
    const double radius = glm::length(scaled);
    const double gradient = glm::length(scaled / half_mm_) / std::max(radius, 1e-9);
    return (radius - 1) / std::max(gradient, 1e-9);
  }
  double volume_mm3() const { return 4.0 / 3 * std::numbers::pi * half_mm_.x * half_mm_.y * half_mm_.z; }

 private:
  glm::dvec3 centre_;
  glm::dvec3 half_mm_;
};

}  // namespace

FigureBlock measure_fluid_volumes(const Workbench& bench) {
  FigureBlock block{"fluid volumes, scanned", kFluidLegend, {}};
  const glm::dvec3 middle(1.7, 34.3, -1.1);
  const std::pair<const char*, Cavity> cavities[] = {
      {"sphere-10", {middle, {10, 10, 10}}},
      {"sphere-14", {middle, {14, 14, 14}}},
      {"sphere-5", {middle, {5, 5, 5}}},
      {"ellipsoid", {middle, {14, 8, 10}}},
  };
  for (const TestFan& fan : test_fans()) {
    const Grains grains(fan, 11);
    for (const Scanner& scanner : scanners()) {
      for (const auto& [shape, cavity] : cavities) {
        const std::string name = fmt::format("fluid/{}/{}/{}", scanner.name, shape, fan.name);
        if (!bench.wants(name)) continue;
        ScannerEcho echo = scanner.echo;
        echo.is_diffuse = true;
        const Volume volume = scanned(fan, cavity, echo, grains);
        const auto region = grown_fluid(volume, {.at = {middle.x + 1, middle.y + 2, middle.z - 1}}, {});
        const EchoLevels l = measured_levels(volume);
        fmt::print("{} {} {} {} known {} flat {} linear {}\n", name, l.fluid, l.tissue, l.noise, l.known, l.flat, l.linear());
        if (!region) fmt::print("{}: {}\n", name, region.error().message);
        const double truth = cavity.volume_mm3();
        const auto percent = [&](double mm3) { return region ? 100 * mm3 / truth : NAN; };
        block.rows.push_back({name,
                              {{"error %", percent(region ? region->volume_mm3 - truth : 0), 1},
                               {"plus-minus %", percent(region ? region->deviation_mm3 : 0), 1},
                               {"fluid", region ? region->fluid_level : NAN, 0},
                               {"border", region ? region->border_level : NAN, 0},
                               {"wall", region ? region->wall_level : NAN, 0}}});
      }
    }
  }
  return block;
}

}  // namespace fanlight::test
