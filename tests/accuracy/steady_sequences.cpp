// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "acquisition/phantom/phantom_options.hpp"
#include "tests/accuracy/depth_errors.hpp"
#include "tests/accuracy/depth_normals.hpp"
#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/known_views.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/phantom_truth.hpp"
#include "tests/accuracy/scanned_frames.hpp"

namespace fanlight::test {

namespace {

constexpr double kSteadyShare = 0.8;  // five volumes
constexpr int kVolumes = 7;

/// A surface that was turned about a point and shifted.
class MovedSurface final : public KnownSurface {
 public:
  MovedSurface(const KnownSurface& surface, const glm::dvec3& pivot, const glm::dvec3& turn_rad,
               const glm::dvec3& shift)
      : surface_(surface), pivot_(pivot), turn_rad_(turn_rad), shift_(shift) {}
  double below_mm(const glm::dvec3& at) const override { return surface_.below_mm(before(at)); }

 private:
  glm::dvec3 before(const glm::dvec3& at) const {
    const glm::dvec3 arm = at - shift_ - pivot_;
    const double angle = glm::length(turn_rad_);
    if (angle == 0) return pivot_ + arm;
    const glm::dvec3 axis = turn_rad_ / angle;
    return pivot_ + std::cos(angle) * arm - std::sin(angle) * glm::cross(axis, arm) +
           (1 - std::cos(angle)) * glm::dot(axis, arm) * axis;
  }

  const KnownSurface& surface_;
  glm::dvec3 pivot_;
  glm::dvec3 turn_rad_;
  glm::dvec3 shift_;
};

/// Two bodies as one.
class UnitedSurface final : public KnownSurface {
 public:
  UnitedSurface(const KnownSurface& first, const KnownSurface& second) : first_(first), second_(second) {}
  double below_mm(const glm::dvec3& at) const override {
    return std::max(first_.below_mm(at), second_.below_mm(at));
  }

 private:
  const KnownSurface& first_;
  const KnownSurface& second_;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

/// What a depth map shows of a known surface.
struct SequenceFigures {
  double normals_90_deg = 0;
  double depth_90_mm = 0;
  double volumes = 1;
};

struct SequenceView {
  Scene scene;
  PictureSize size;
};

SequenceFigures judged(const SequenceView& view, const DepthMaps& maps, const std::vector<PixelTruth>& truth,
             const KnownSurface& surface) {
  const PixelRays rays(view.scene, view.size);
  const DepthNormals normals(maps.smooth_mm, view.size, rays, view.scene.light.normals, view.scene.filter.step_mm);
  std::vector<double> errors_mm;
  for (std::size_t pixel = 0; pixel < truth.size(); ++pixel) {
    if (truth[pixel].meets != Meets::kSurface || maps.smooth_mm[pixel] < 0) continue;
    const double error = std::abs(maps.smooth_mm[pixel] - truth[pixel].depth_mm);
    if (error <= kFoundMm) errors_mm.push_back(error);
  }
  return {.normals_90_deg =
              quantile(normal_errors_deg(normals, maps.smooth_mm, truth, rays, view.size, surface), 0.9),
          .depth_90_mm = quantile(errors_mm, 0.9)};
}

/// The last of a sequence of volumes, with the filter and without.
struct SinglesAndSteady {
  SequenceFigures single;
  SequenceFigures steady;
};

FigureRow row(const std::string& name, const SinglesAndSteady& compared, std::optional<Demand> normals = {}, std::optional<Demand> depths = {}) {
  return {name,
          {{"1: normals deg", compared.single.normals_90_deg, 2},
           {"steady", compared.steady.normals_90_deg, 2},
           {"times", compared.single.normals_90_deg / compared.steady.normals_90_deg, 2, normals},
           {"1: depths mm", compared.single.depth_90_mm, 3},
           {"steady", compared.steady.depth_90_mm, 3},
           {"times", compared.single.depth_90_mm / compared.steady.depth_90_mm, 2, depths},
           {"volumes", compared.steady.volumes, 1}}};
}

class SteadySequences {
 public:
  explicit SteadySequences(const Workbench& bench) : bench_(bench) {}

  void measure_phantom(const char* text) {
    const std::string name = fmt::format("steady/phantom/{}", text);
    if (!bench_.wants(name)) return;
    auto config = parse_phantom(fmt::format("{},moving=off", text), usual_phantom());
    config->pace = PhantomSource::Pace::kUnpaced;
    const auto source = made_phantom(*config);
    const SourceDescription& description = source->description();
    const ScannedFan fan{.geometry = description.geometry,
                         .first_angle_rad = description.first_angle_rad,
                         .last_angle_rad = description.last_angle_rad};
    SequenceView view{.scene = scene_for(fan.geometry, fan.first_angle_rad, fan.last_angle_rad, 512),
                      .size = {512, 512}};
    bench_.change(view.scene);
    const auto surface = surface_of(*source);
    const auto truth = depth_truth(PixelRays(view.scene, view.size), view.size, fan, *surface);
    DepthRig rig(bench_.gpu, fan, description.frames_per_volume, view.size);
    SinglesAndSteady compared;
    for (int number = 1; number <= kVolumes; ++number) {
      Volume volume = next_sweep(*source);
      volume.stamp().volume_id = static_cast<std::uint64_t>(number);
      compared = both(rig, view, volume, truth, *surface, number == kVolumes);
    }
    block.rows.push_back(row(name, compared, at_least(1.6)));
  }

  /// `body`: whether the whole body moves, mm and deg a volume; `ball_mm`: what a ball before it moves.
  void measure_moved(const char* label, const TestFan& fan, const glm::dvec3& shift_mm, const glm::dvec3& turn_deg,
                     std::optional<double> ball_mm) {
    const std::string name = fmt::format("steady/{}/{}", label, fan.name);
    if (!bench_.wants(name)) return;
    const KnownRelief relief(kSurfaceDepthMm);
    const ScannedFan scanned_fan = fan.scanned();
    DepthRig rig(bench_.gpu, scanned_fan, static_cast<std::uint32_t>(fan.angles_rad.size()), kViewSize);
    SinglesAndSteady compared;
    for (int number = 1; number <= kVolumes; ++number) {
      // To and fro, as a probe in a hand.
      const double share = std::sin(1.3 * number);
      const MovedSurface moved(relief, {0, kSurfaceDepthMm, 0}, share * turn_deg * (std::numbers::pi / 180),
                               share * shift_mm);
      const glm::dvec3 start(-6, kSurfaceDepthMm - 4.0, 1);
      const KnownSphere ball(start + glm::dvec3(number * ball_mm.value_or(0), 0.3 * number * ball_mm.value_or(0), 0),
                             ball_mm ? 5.0 : 0.01);
      const UnitedSurface united(moved, ball);
      KnownView known = known_views(scanned_fan, united, Projection::kParallel).front();
      SequenceView view{.scene = known.scene, .size = known.size};
      bench_.change(view.scene);
      Volume volume = scanned(fan, united, scanners().front().echo, grains(fan, 100 + number));
      volume.stamp().volume_id = static_cast<std::uint64_t>(number);
      std::vector<PixelTruth> truth = known.truth;
      if (ball_mm) {  // the ball alone
        const PixelRays rays(view.scene, view.size);
        for (std::size_t pixel = 0; pixel < truth.size(); ++pixel) {
          if (truth[pixel].meets != Meets::kSurface) continue;
          const glm::dvec3 at = rays.ray(static_cast<std::uint32_t>(pixel % view.size.width), static_cast<std::uint32_t>(pixel / view.size.width)).at(truth[pixel].depth_mm);
          if (std::abs(ball.below_mm(at)) > 0.01 || truth[pixel].incidence_deg > 60) truth[pixel].meets = Meets::kNothing;
        }
      }
      compared = both(rig, view, volume, truth, united, number == kVolumes);
    }
    block.rows.push_back(row(name, compared));
  }

  FigureBlock block{"sequences: filter.steady 0.8, the last of seven volumes", "...", {}};

 private:
  SinglesAndSteady both(DepthRig& rig, const SequenceView& view, const Volume& volume, const std::vector<PixelTruth>& truth,
                const KnownSurface& surface, bool judges) {
    SequenceView steady = view;
    steady.scene.filter.steady = kSteadyShare;
    rig.set_volume(volume);
    SinglesAndSteady compared;
    const DepthMaps averaged = rig.depths(steady.scene);
    if (!judges) return compared;
    compared.steady = judged(steady, averaged, truth, surface);
    compared.steady.volumes = rig.picture().stamp.mean_volumes;
    SequenceView single = view;
    single.scene.filter.steady = 0;
    compared.single = judged(single, rig.depths(single.scene), truth, surface);
    return compared;
  }

  const Grains& grains(const TestFan& fan, std::uint64_t seed) {
    auto& kept = grains_[{fan.name, seed}];
    if (!kept) kept = std::make_unique<Grains>(fan, seed);
    return *kept;
  }

  const Workbench& bench_;
  std::map<std::pair<std::string, std::uint64_t>, std::unique_ptr<Grains>> grains_;
};

}  // namespace

FigureBlock measure_steady_sequences(const Workbench& bench) {
  SteadySequences sequences(bench);
  sequences.measure_phantom("scene=face");
  sequences.measure_phantom("scene=face,speckle=off");
  for (const TestFan& fan : test_fans()) {
    if (fan.name != "convex") continue;
    sequences.measure_moved("rest", fan, {}, {}, std::nullopt);
    sequences.measure_moved("tremor", fan, {0.6, 0.4, -0.5}, {0.8, 1.0, -0.6}, std::nullopt);
    sequences.measure_moved("hand", fan, {1.5, 1, -1.5}, {2, 3, -2}, std::nullopt);
    for (const double mm : {0.0, 0.1, 0.2, 0.4, 1.0, 3.0})
      sequences.measure_moved(fmt::format("ball-{}", mm).c_str(), fan, {}, {}, mm);
    sequences.measure_moved("ball-moved", fan, {0.6, 0.4, -0.5}, {0.8, 1.0, -0.6}, 0.5);
  }
  return std::move(sequences.block);
}

}  // namespace fanlight::test
