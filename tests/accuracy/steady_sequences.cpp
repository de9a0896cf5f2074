// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
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

constexpr char kSteadyLegend[] =
    R"(The last of seven volumes: with filter.steady 0.8 (five volumes) over the same volume alone. normals, depths: 90 % of the
errors, of pixels whose surface is found within 1.5 mm; gain: alone over steady. volumes: mean number in a pixel's mean.
phantom: the simulated probe's face at rest, whose normals are 5.1 deg off without speckle too. The others are frames of the
usual scanner over a relief. Other speckle in each volume, but for same-speckle: a body that does not move at all shows the
same again. tremor, moved: the relief moves as one body, by up to 0.9 mm and 1.4 deg, or 2.3 mm and 4.1 deg, from its
place. finger: a ball of 10 mm before it, judged alone, moves so many mm a volume; tremor-finger: both.)";

/// A surface that was turned about a point and shifted.
class MovedSurface final : public KnownSurface {
 public:
  struct Pose {
    glm::dvec3 pivot_mm{};
    glm::dvec3 turn_rad{};  ///< about its direction
    glm::dvec3 shift_mm{};
  };
  MovedSurface(const KnownSurface& surface, const Pose& pose) : surface_(surface), pose_(pose) {}
  double below_mm(const glm::dvec3& at) const override { return surface_.below_mm(before(at)); }

 private:
  glm::dvec3 before(const glm::dvec3& at) const {
    const glm::dvec3 arm = at - pose_.shift_mm - pose_.pivot_mm;
    const double angle = glm::length(pose_.turn_rad);
    if (angle == 0) return pose_.pivot_mm + arm;
    const glm::dvec3 axis = pose_.turn_rad / angle;
    return pose_.pivot_mm + std::cos(angle) * arm - std::sin(angle) * glm::cross(axis, arm) +
           (1 - std::cos(angle)) * glm::dot(axis, arm) * axis;
  }

  const KnownSurface& surface_;
  Pose pose_;
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

/// How the volumes of a sequence differ.
struct Movement {
  const char* name;
  glm::dvec3 shift_mm{};  ///< of the body, to and fro
  glm::dvec3 turn_deg{};
  std::optional<double> finger_mm = {};  ///< a volume; absent: there is none
  bool same_speckle = false;
  std::optional<Demand> least_gain = {};  ///< of normals
};

const Movement kMovements[] = {
    {.name = "rest", .least_gain = at_least(1.6)},
    {.name = "same-speckle", .same_speckle = true, .least_gain = at_least(0.95)},
    {.name = "tremor",
     .shift_mm = {0.6, 0.4, -0.5},
     .turn_deg = {0.8, 1.0, -0.6},
     .least_gain = at_least(1.6)},
    {.name = "moved", .shift_mm = {1.5, 1, -1.5}, .turn_deg = {2, 3, -2}, .least_gain = at_least(1.4)},
    {.name = "finger-0", .finger_mm = 0, .least_gain = at_least(1)},
    {.name = "finger-0.1", .finger_mm = 0.1, .least_gain = at_least(0.95)},
    {.name = "finger-0.2", .finger_mm = 0.2, .least_gain = at_least(0.95)},
    {.name = "finger-0.4", .finger_mm = 0.4, .least_gain = at_least(0.95)},
    {.name = "finger-1", .finger_mm = 1, .least_gain = at_least(0.95)},
    {.name = "finger-3", .finger_mm = 3, .least_gain = at_least(0.95)},
    {.name = "tremor-finger",
     .shift_mm = {0.6, 0.4, -0.5},
     .turn_deg = {0.8, 1.0, -0.6},
     .finger_mm = 0.5,
     .least_gain = at_least(0.95)},
};

double quantile_90(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto at = static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

/// What a depth map shows of a known surface, 90 % of the errors.
struct SequenceErrors {
  double normals_deg = 0;
  double depths_mm = 0;
};

/// The last volume of a sequence.
struct SequenceResult {
  SequenceErrors alone;
  SequenceErrors steady;
  double volumes = 1;
};

FigureRow sequence_row(const std::string& name, const SequenceResult& result,
                       const std::optional<Demand>& least_gain) {
  const double depth_gain = result.alone.depths_mm / result.steady.depths_mm;
  return {name,
          {{"normals deg", result.alone.normals_deg, 2},
           {"steady", result.steady.normals_deg, 2},
           {"gain", result.alone.normals_deg / result.steady.normals_deg, 2, least_gain},
           {"depths mm", result.alone.depths_mm, 3},
           {"steady", result.steady.depths_mm, 3},
           {"gain", depth_gain, 2, at_least(0.95)},
           {"volumes", result.volumes, 1}}};
}

class SteadySequences {
 public:
  explicit SteadySequences(const Workbench& bench) : bench_(bench) {}

  void measure_phantom() {
    const std::string name = "steady/phantom/face";
    if (!bench_.wants(name)) return;
    auto config = parse_phantom("scene=face,moving=off", usual_phantom());
    if (!config) throw std::runtime_error(config.error().message);
    config->pace = PhantomSource::Pace::kUnpaced;
    const auto source = made_phantom(*config);
    const SourceDescription& description = source->description();
    const ScannedFan fan{.geometry = description.geometry,
                         .first_angle_rad = description.first_angle_rad,
                         .last_angle_rad = description.last_angle_rad};
    constexpr PictureSize kSize{.width = 512, .height = 512};
    Scene scene = scene_for(fan.geometry, fan.first_angle_rad, fan.last_angle_rad, kSize.height);
    bench_.change(scene);
    const auto surface = surface_of(*source);
    const PixelRays rays(scene, kSize);
    const KnownView view{scene, kSize, rays, depth_truth(rays, kSize, fan, *surface)};
    DepthRig rig(bench_.gpu, fan, description.frames_per_volume, kSize);
    for (int number = 1; number < kVolumes; ++number) take(rig, view, next_sweep(*source), number);
    const SequenceResult result = judged(rig, view, next_sweep(*source), *surface);
    block.rows.push_back(sequence_row(name, result, at_least(1.2)));
  }

  void measure(const TestFan& fan, const Movement& movement) {
    const std::string name = fmt::format("steady/{}/{}", movement.name, fan.name);
    if (!bench_.wants(name)) return;
    DepthRig rig(bench_.gpu, fan.scanned(), static_cast<std::uint32_t>(fan.angles_rad.size()), kViewSize);
    const KnownRelief relief(kSurfaceDepthMm);
    for (int number = 1; number <= kVolumes; ++number) {
      const double share = std::sin(1.3 * number);  // to and fro, as a probe in a hand
      const MovedSurface moved(relief, {.pivot_mm = {0, kSurfaceDepthMm, 0},
                                        .turn_rad = radians(1) * share * movement.turn_deg,
                                        .shift_mm = share * movement.shift_mm});
      const double way_mm = number * movement.finger_mm.value_or(0);
      const KnownSphere finger(glm::dvec3(way_mm - 6, kSurfaceDepthMm - 4 + 0.3 * way_mm, 1),
                               movement.finger_mm ? 5.0 : 0.01);
      const UnitedSurface united(moved, finger);
      KnownView view = known_views(fan.scanned(), united, Projection::kParallel).front();
      bench_.change(view.scene);
      const Grains& grains = this->grains(fan, movement.same_speckle ? 1 : number);
      Volume volume = scanned(fan, united, scanners().front().echo, grains);
      if (number < kVolumes) {
        take(rig, view, std::move(volume), number);
        continue;
      }
      if (movement.finger_mm) judge_alone(view, finger);
      block.rows.push_back(
          sequence_row(name, judged(rig, view, std::move(volume), united), movement.least_gain));
    }
  }

  FigureBlock block{"sequences: filter.steady", kSteadyLegend, {}};

 private:
  /// Leaves the truth of what is seen of a body at less than 60 deg.
  static void judge_alone(KnownView& view, const KnownSurface& body) {
    constexpr double kSteepDeg = 60;
    for (std::size_t pixel = 0; pixel < view.truth.size(); ++pixel) {
      PixelTruth& truth = view.truth[pixel];
      if (truth.meets != Meets::kSurface) continue;
      const PixelRay ray = view.rays.ray(static_cast<std::uint32_t>(pixel % view.size.width),
                                         static_cast<std::uint32_t>(pixel / view.size.width));
      const bool is_body = std::abs(body.below_mm(ray.at(truth.depth_mm))) < 0.01;
      if (!is_body || truth.incidence_deg > kSteepDeg) truth.meets = Meets::kNothing;
    }
  }

  /// Shows a volume of the sequence.
  static DepthMaps take(DepthRig& rig, const KnownView& view, Volume volume, int number) {
    volume.stamp().volume_id = static_cast<std::uint64_t>(number);
    Scene scene = view.scene;
    scene.filter.steady = kSteadyShare;
    rig.set_volume(volume);
    return rig.depths(scene);
  }

  static SequenceResult judged(DepthRig& rig, const KnownView& view, Volume volume,
                               const KnownSurface& surface) {
    SequenceResult result;
    result.steady = errors(view, take(rig, view, std::move(volume), kVolumes), surface);
    result.volumes = rig.picture().stamp.mean_volumes;
    result.alone = errors(view, rig.depths(view.scene), surface);
    return result;
  }

  static SequenceErrors errors(const KnownView& view, const DepthMaps& maps, const KnownSurface& surface) {
    const DepthNormals normals(maps.smooth_mm, view.size, view.rays, view.scene.light.normals,
                               view.scene.filter.step_mm);
    std::vector<double> errors_mm;
    for (std::size_t pixel = 0; pixel < view.truth.size(); ++pixel) {
      if (view.truth[pixel].meets != Meets::kSurface || maps.smooth_mm[pixel] < 0) continue;
      const double error_mm = std::abs(maps.smooth_mm[pixel] - view.truth[pixel].depth_mm);
      if (error_mm <= kFoundMm) errors_mm.push_back(error_mm);
    }
    return {.normals_deg = quantile_90(
                normal_errors_deg(normals, maps.smooth_mm, view.truth, view.rays, view.size, surface)),
            .depths_mm = quantile_90(std::move(errors_mm))};
  }

  const Grains& grains(const TestFan& fan, int number) {
    return grains_.try_emplace(number, fan, 100 + static_cast<std::uint64_t>(number)).first->second;
  }

  const Workbench& bench_;
  std::map<int, Grains> grains_;  // of one fan, by the number of the volume
};

}  // namespace

FigureBlock measure_steady_sequences(const Workbench& bench) {
  SteadySequences sequences(bench);
  sequences.measure_phantom();
  const auto fans = test_fans();
  const auto convex = std::ranges::find(fans, "convex", &TestFan::name);
  for (const Movement& movement : kMovements) sequences.measure(*convex, movement);
  return std::move(sequences.block);
}

}  // namespace fanlight::test
