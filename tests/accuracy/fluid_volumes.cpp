// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/survey/fluid_region.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/scanned_frames.hpp"

namespace fanlight::test {

namespace {

constexpr char kFluidLegend[] =
    R"(Ellipsoids of fluid in tissue, in frames as a scanner makes them (see above), grown from a point beside their middle.
Scatterers without order, whose powers add; "-amplitude": the amplitude is blurred, as in the rows scanned/...
error: of the volume. plus-minus: the deviation that is given for it. ratio: of the error to that.)";

/// The inside of an ellipsoid is fluid.
class Cavity final : public KnownSurface {
 public:
  Cavity(const glm::dvec3& centre, const glm::dvec3& half_axes_mm)
      : centre_(centre), half_mm_(half_axes_mm) {}
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
  struct Shape {
    const char* name;
    Cavity cavity;
  };
  const Shape shapes[] = {{"sphere-5", {middle, {5, 5, 5}}},
                          {"sphere-10", {middle, {10, 10, 10}}},
                          {"sphere-14", {middle, {14, 14, 14}}},
                          {"ellipsoid-14x8x10", {middle, {14, 8, 10}}}};
  for (const TestFan& fan : test_fans()) {
    std::optional<Grains> grains;
    const auto measure = [&](const Scanner& scanner, bool is_diffuse, const Shape& shape) {
      const std::string name =
          fmt::format("fluid/{}{}/{}/{}", scanner.name, is_diffuse ? "" : "-amplitude", shape.name, fan.name);
      if (!bench.wants(name)) return;
      if (!grains) grains.emplace(fan, 11);
      ScannerEcho echo = scanner.echo;
      echo.is_diffuse = is_diffuse;
      const Volume volume = scanned(fan, shape.cavity, echo, *grains);
      const auto region = grown_fluid(volume, {.at = {middle.x + 1, middle.y + 2, middle.z - 1}}, {});
      const double truth = shape.cavity.volume_mm3();
      const double error = region ? 100 * (region->volume_mm3 / truth - 1) : NAN;
      const double deviation = region ? 100 * region->deviation_mm3 / truth : NAN;
      // A broad beam is as wide as the smaller ones, and takes a part of each.
      const bool is_usual = is_diffuse && std::string_view(scanner.name) != "broad-beam";
      const bool is_sphere = std::string_view(shape.name).starts_with("sphere-1");
      const auto demand = is_usual && is_sphere ? std::optional(at_most(2)) : std::nullopt;
      block.rows.push_back({name,
                            {{"error %", error, 1},
                             {"off %", std::abs(error), 1, demand},
                             {"plus-minus %", deviation, 1},
                             {"ratio", std::abs(error) / deviation, 2, at_most(1)}}});
    };
    for (const Scanner& scanner : scanners())
      for (const bool is_diffuse : {true, false})
        for (const Shape& shape : shapes) measure(scanner, is_diffuse, shape);
  }
  return block;
}

}  // namespace fanlight::test
