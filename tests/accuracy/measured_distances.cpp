// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/accuracy/depth_errors.hpp"
#include "tests/accuracy/known_views.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/scanned_frames.hpp"

namespace fanlight::test {

namespace {

constexpr double kLeastMm = 3;
constexpr std::uint32_t kBetween = 9;  // pixels from one point to the next
constexpr double kUsualShare = 0.68;   // of a normal distribution, within one deviation

constexpr char kDistanceLegend[] =
    R"(Distances between two points of the surface, in frames as a scanner makes them (see above), default scene: from the
probe and from two oblique directions, in parallel projection and in perspective. All pairs of a grid of pixels whose
rays meet the surface at less than 75 deg, 3 mm apart or more. A point is computed from the depth shown and Picture.view,
as a display does; the true point lies on the same ray.
signed: median of measured - true distance. 68 %, 90 %: of the errors without their sign. plus-minus: median of the
deviation that a display gives, from the distance of the samples and the size of a pixel. ratio: of 68 % to that.)";

struct Direction {
  const char* name;
  double yaw_deg;
  double pitch_deg;
  double roll_deg;
};
constexpr Direction kDirections[] = {{"front", 0, 0, 0}, {"left", 20, -15, 30}, {"right", -25, 20, -10}};

struct MeasuredPoint {
  glm::dvec3 shown;
  glm::dvec3 real;
};

glm::dvec3 vector_of(const std::array<double, 3>& values) {
  return {values[0], values[1], values[2]};
}

/// By the formula at View in proto/fanlight.proto.
glm::dvec3 point_of(const PictureView& view, std::uint32_t column, std::uint32_t row, double depth_mm) {
  const double scale = view.mm_per_pixel + depth_mm * view.mm_per_pixel_per_mm;
  return vector_of(view.origin_mm) + depth_mm * vector_of(view.forward) +
         scale * ((column - view.middle_column) * vector_of(view.right) +
                  (row - view.middle_row) * vector_of(view.down));
}

std::vector<MeasuredPoint> measured_points(const KnownView& view, const Picture& picture) {
  std::vector<MeasuredPoint> points;
  for (std::uint32_t row = kBetween / 2; row < view.size.height; row += kBetween) {
    for (std::uint32_t column = kBetween / 2; column < view.size.width; column += kBetween) {
      const std::size_t pixel = std::size_t{row} * view.size.width + column;
      const PixelTruth& truth = view.truth[pixel];
      const double depth_mm = picture.depth_mm[pixel];
      if (truth.meets != Meets::kSurface || truth.incidence_deg >= kRimDeg || depth_mm < 0) continue;
      points.push_back({.shown = point_of(picture.stamp.view, column, row, depth_mm),
                        .real = view.rays.ray(column, row).at(truth.depth_mm)});
    }
  }
  return points;
}

/// As placeSdMm() and figuresOf() of the page: each point is uncertain by a sample and a pixel.
double stated_deviation_mm(const glm::dvec3& between, const Point& samples, double pixel_mm) {
  const glm::dvec3 along = glm::normalize(between);
  const glm::dvec3 sample(samples.x_mm, samples.y_mm, samples.z_mm);
  const glm::dvec3 variance = (sample * sample + pixel_mm * pixel_mm) / 12.0;
  return std::sqrt(2 * glm::dot(along * along, variance));
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

std::vector<Figure> figures_of(const std::vector<MeasuredPoint>& points, const Point& samples,
                               double pixel_mm, bool is_usual) {
  std::vector<double> errors_mm;
  std::vector<double> off_mm;
  std::vector<double> stated_mm;
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double real_mm = glm::distance(points[a].real, points[b].real);
      if (real_mm < kLeastMm) continue;
      const glm::dvec3 between = points[a].shown - points[b].shown;
      errors_mm.push_back(glm::length(between) - real_mm);
      off_mm.push_back(std::abs(errors_mm.back()));
      stated_mm.push_back(stated_deviation_mm(between, samples, pixel_mm));
    }
  }
  const double usual_mm = quantile(off_mm, kUsualShare);
  const double plus_minus_mm = quantile(stated_mm, 0.5);
  const auto demand = is_usual ? std::optional(at_most(0.3)) : std::nullopt;
  return {{"pairs", static_cast<double>(errors_mm.size()), 0, at_least(100)},
          {"signed mm", quantile(errors_mm, 0.5)},
          {"68 % mm", usual_mm},
          {"90 % mm", quantile(off_mm, 0.9), 3, demand},
          {"plus-minus mm", plus_minus_mm},
          {"ratio", usual_mm / plus_minus_mm, 2}};
}

class Distances {
 public:
  explicit Distances(const Workbench& bench) : bench_(bench) {}

  void measure(const TestFan& fan) {
    std::optional<Grains> grains;
    for (const Scanner& scanner : scanners()) {
      for (const TestSurface& surface : test_surfaces()) {
        if (surface.name != "sphere" && surface.name != "relief") continue;
        const std::string begin = fmt::format("distance/{}/{}/", scanner.name, surface.name);
        const std::vector<Wanted> wanted = wanted_rows(begin, fan.name);
        if (wanted.empty()) continue;
        if (!grains) grains.emplace(fan, 5);
        const Volume volume = scanned(fan, *surface.surface, scanner.echo, *grains);
        for (const Wanted& row : wanted) add(row, fan, *surface.surface, scanner, volume);
      }
    }
  }

  FigureBlock block{"distances on the surface, scanned", kDistanceLegend, {}};

 private:
  struct Wanted {
    std::string name;
    Projection projection;
    Direction direction;
  };

  std::vector<Wanted> wanted_rows(const std::string& begin, const std::string& fan) const {
    std::vector<Wanted> rows;
    for (const Projection projection : {Projection::kParallel, Projection::kPerspective}) {
      for (const Direction& direction : kDirections) {
        const char* const word = projection == Projection::kParallel ? "parallel" : "perspective";
        Wanted row{fmt::format("{}{}-{}/{}", begin, direction.name, word, fan), projection, direction};
        if (bench_.wants(row.name)) rows.push_back(std::move(row));
      }
    }
    return rows;
  }

  void add(const Wanted& row, const TestFan& fan, const KnownSurface& surface, const Scanner& scanner,
           const Volume& volume) {
    Scene scene = scene_from_probe(fan.scanned(), row.projection);
    scene.camera.yaw_deg = row.direction.yaw_deg;
    scene.camera.pitch_deg = row.direction.pitch_deg;
    scene.camera.roll_deg = row.direction.roll_deg;
    KnownView view = known_view(scene, fan.scanned(), surface);
    bench_.change(view.scene);
    DepthRig rig(bench_.gpu, fan.scanned(), static_cast<std::uint32_t>(fan.angles_rad.size()), view.size);
    rig.set_volume(volume);
    (void)rig.depths(view.scene);
    const bool is_usual = std::string_view(scanner.name) != "broad-beam";
    block.rows.push_back(
        {row.name, figures_of(measured_points(view, rig.picture()), rig.picture().stamp.sample_distances,
                              view.rays.port().pixel_mm, is_usual)});
  }

  const Workbench& bench_;
};

}  // namespace

FigureBlock measure_distances(const Workbench& bench) {
  Distances distances(bench);
  for (const TestFan& fan : test_fans()) distances.measure(fan);
  return distances.block;
}

}  // namespace fanlight::test
