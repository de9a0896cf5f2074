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
#include "tests/accuracy/scatterers.hpp"

namespace fanlight::test {

namespace {

constexpr double kSteadyShare = 0.8;  // five volumes
constexpr int kVolumes = 7;

constexpr char kSteadyLegend[] =
    R"(The last of seven volumes: with filter.steady 0.8 (five volumes) over the same volume alone. normals, depths: 90 % of the
errors, of pixels whose surface is found within 1.5 mm in the volume alone; gain: alone over steady. share, volumes: of the
surface that is a mean over volumes, and of how many.
phantom: the simulated probe's face at rest, whose normals are 5.1 deg off without speckle too. The others are frames of the
usual scanner over a relief. Other speckle in each volume, but for same-speckle: a body that does not move at all shows the
same again; and for scatterers-...: echoes of points that belong to the body and move with it. tremor, moved: the relief
moves as one body, by up to 0.9 mm and 1.4 deg, or 2.3 mm and 4.1 deg, from its place. finger: a ball of 10 mm before it,
judged alone, moves so many mm a volume; tremor-finger: both; uncovered: what the ball of finger-3 has left, judged alone.
bent: the relief bends, in waves of 30 mm, by so many mm more with each volume.)";

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

  /// Where a point of the surface is now.
  glm::dvec3 after(const glm::dvec3& at) const {
    return pose_.pivot_mm + pose_.shift_mm + turned(at - pose_.pivot_mm, 1);
  }

 private:
  glm::dvec3 before(const glm::dvec3& at) const {
    return pose_.pivot_mm + turned(at - pose_.shift_mm - pose_.pivot_mm, -1);
  }
  glm::dvec3 turned(const glm::dvec3& arm, double sign) const {
    const double angle = glm::length(pose_.turn_rad);
    if (angle == 0) return arm;
    const glm::dvec3 axis = sign * pose_.turn_rad / angle;
    return std::cos(angle) * arm + std::sin(angle) * glm::cross(axis, arm) +
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

/// A surface that bends in depth, by a wave along x.
class BentSurface final : public KnownSurface {
 public:
  BentSurface(const KnownSurface& surface, double bent_mm) : surface_(surface), bent_mm_(bent_mm) {}
  double below_mm(const glm::dvec3& at) const override {
    return surface_.below_mm({at.x, at.y - bent_mm_ * std::sin(at.x / 4.8), at.z});
  }

 private:
  const KnownSurface& surface_;
  double bent_mm_;
};

/// How the volumes of a sequence differ.
struct Movement {
  const char* name;
  glm::dvec3 shift_mm{};  ///< of the body, to and fro
  glm::dvec3 turn_deg{};
  std::optional<double> finger_mm = {};  ///< a volume; absent: there is none
  bool judges_uncovered = false;         ///< in place of the finger
  double bent_mm = 0;                    ///< more with each volume, in depth
  bool same_speckle = false;
  bool scatterers = false;                ///< of the body's own
  std::optional<Demand> least_gain = {};  ///< of normals
  double least_depth_gain = 0.95;
};

const Movement kMovements[] = {
    {.name = "rest", .least_gain = at_least(1.6)},
    {.name = "same-speckle", .same_speckle = true, .least_gain = at_least(0.95)},
    {.name = "tremor",
     .shift_mm = {0.6, 0.4, -0.5},
     .turn_deg = {0.8, 1.0, -0.6},
     .least_gain = at_least(1.6)},
    {.name = "moved", .shift_mm = {1.5, 1, -1.5}, .turn_deg = {2, 3, -2}, .least_gain = at_least(1.4)},
    {.name = "scatterers-rest", .scatterers = true, .least_gain = at_least(0.95)},
    {.name = "scatterers-tremor",
     .shift_mm = {0.6, 0.4, -0.5},
     .turn_deg = {0.8, 1.0, -0.6},
     .scatterers = true,
     .least_gain = at_least(0.95)},
    {.name = "scatterers-moved",
     .shift_mm = {1.5, 1, -1.5},
     .turn_deg = {2, 3, -2},
     .scatterers = true,
     .least_gain = at_least(0.95)},
    {.name = "finger-0", .finger_mm = 0, .least_gain = at_least(1)},
    {.name = "finger-0.1", .finger_mm = 0.1, .least_gain = at_least(0.95)},
    {.name = "finger-0.2", .finger_mm = 0.2, .least_gain = at_least(0.95)},
    {.name = "finger-0.4", .finger_mm = 0.4, .least_gain = at_least(0.95)},
    {.name = "finger-1", .finger_mm = 1, .least_gain = at_least(0.95)},
    {.name = "finger-3", .finger_mm = 3, .least_gain = at_least(0.95)},
    {.name = "uncovered-3", .finger_mm = 3, .judges_uncovered = true, .least_gain = at_least(0.95)},
    {.name = "bent-0.1", .bent_mm = 0.1, .least_gain = at_least(0.95), .least_depth_gain = 0.8},
    {.name = "bent-0.3", .bent_mm = 0.3, .least_gain = at_least(0.95), .least_depth_gain = 0.8},
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
  double steady_share = 0;
  double volumes = 1;
};

FigureRow sequence_row(const std::string& name, const SequenceResult& result,
                       const std::optional<Demand>& least_gain, double least_depth_gain = 0.95) {
  const double depth_gain = result.alone.depths_mm / result.steady.depths_mm;
  return {name,
          {{"normals deg", result.alone.normals_deg, 2},
           {"steady", result.steady.normals_deg, 2},
           {"gain", result.alone.normals_deg / result.steady.normals_deg, 2, least_gain},
           {"depths mm", result.alone.depths_mm, 3},
           {"steady", result.steady.depths_mm, 3},
           {"gain", depth_gain, 2, at_least(least_depth_gain)},
           {"share %", 100 * result.steady_share, 0},
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
    for (int number = 1; number < kVolumes; ++number) take(rig, scene, next_sweep(*source), number);
    const SequenceResult result = judged(rig, view, next_sweep(*source), *surface);
    block.rows.push_back(sequence_row(name, result, at_least(1.2)));
  }

  void measure(const TestFan& fan, const Movement& movement) {
    const std::string name = fmt::format("steady/{}/{}", movement.name, fan.name);
    if (!bench_.wants(name)) return;
    DepthRig rig(bench_.gpu, fan.scanned(), static_cast<std::uint32_t>(fan.angles_rad.size()), kViewSize);
    Scene scene = scene_from_probe(fan.scanned(), Projection::kParallel);
    bench_.change(scene);
    const KnownRelief relief(kSurfaceDepthMm);
    std::optional<Scatterers> scatterers;
    if (movement.scatterers) scatterers.emplace(fan, relief, 7);
    for (int number = 1; number <= kVolumes; ++number) {
      const double share = std::sin(1.3 * number);  // to and fro, as a probe in a hand
      const BentSurface bent(relief, number * movement.bent_mm);
      const MovedSurface moved(bent, {.pivot_mm = {0, kSurfaceDepthMm, 0},
                                      .turn_rad = radians(1) * share * movement.turn_deg,
                                      .shift_mm = share * movement.shift_mm});
      const auto finger_at = [&](int volume) {
        const double way_mm = volume * movement.finger_mm.value_or(0);
        return KnownSphere({way_mm - 6, kSurfaceDepthMm - 4 + 0.3 * way_mm, 1},
                           movement.finger_mm ? 5.0 : 0.01);
      };
      const KnownSphere finger = finger_at(number);
      const UnitedSurface united(moved, finger);
      const Grains& grains = this->grains(fan, movement.same_speckle ? 1 : number);
      const ScannerEcho& echo = scanners().front().echo;
      Volume volume = scatterers ? scatterers->scanned([&](const glm::dvec3& at) { return moved.after(at); },
                                                       echo, grains.noise)
                                 : scanned(fan, united, echo, grains);
      if (number < kVolumes) {
        take(rig, scene, std::move(volume), number);
        continue;
      }
      KnownView view = view_from_probe(fan.scanned(), united, Projection::kParallel);
      view.scene = scene;
      if (movement.judges_uncovered) {
        judge_uncovered(view, finger_at(number - 1), finger);
      } else if (movement.finger_mm) {
        judge_alone(view, finger);
      }
      block.rows.push_back(sequence_row(name, judged(rig, view, std::move(volume), united),
                                        movement.least_gain, movement.least_depth_gain));
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

  /// Leaves the truth of what `before` has covered and `now` does not.
  static void judge_uncovered(KnownView& view, const KnownSurface& before, const KnownSurface& now) {
    for (std::size_t pixel = 0; pixel < view.truth.size(); ++pixel) {
      PixelTruth& truth = view.truth[pixel];
      if (truth.meets != Meets::kSurface) continue;
      const PixelRay ray = view.rays.ray(static_cast<std::uint32_t>(pixel % view.size.width),
                                         static_cast<std::uint32_t>(pixel / view.size.width));
      const auto covers = [&](const KnownSurface& body) {
        return body.entry_mm(ray, view.rays.first_mm(), view.rays.last_mm()).has_value();
      };
      if (!covers(before) || covers(now)) truth.meets = Meets::kNothing;
    }
  }

  /// Shows a volume of the sequence.
  static DepthMaps take(DepthRig& rig, Scene scene, Volume volume, int number) {
    volume.stamp().volume_id = static_cast<std::uint64_t>(number);
    scene.filter.steady = kSteadyShare;
    rig.set_volume(volume);
    return rig.depths(scene);
  }

  static SequenceResult judged(DepthRig& rig, KnownView view, Volume volume, const KnownSurface& surface) {
    SequenceResult result;
    const DepthMaps steady = take(rig, view.scene, std::move(volume), kVolumes);
    result.steady_share = rig.picture().stamp.steady_share;
    result.volumes = rig.picture().stamp.mean_volumes;
    const DepthMaps alone = rig.depths(view.scene);
    // The same pixels of both.
    for (std::size_t pixel = 0; pixel < view.truth.size(); ++pixel) {
      const bool found = alone.smooth_mm[pixel] >= 0 && steady.smooth_mm[pixel] >= 0 &&
                         std::abs(alone.smooth_mm[pixel] - view.truth[pixel].depth_mm) <= kFoundMm;
      if (!found) view.truth[pixel].meets = Meets::kNothing;
    }
    result.alone = errors(view, alone, surface);
    result.steady = errors(view, steady, surface);
    return result;
  }

  static SequenceErrors errors(const KnownView& view, const DepthMaps& maps, const KnownSurface& surface) {
    const DepthNormals normals(maps.smooth_mm, view.size, view.rays, view.scene.light.normals,
                               view.scene.filter.step_mm);
    std::vector<double> errors_mm;
    std::vector<double> errors_deg;
    for (std::size_t pixel = 0; pixel < view.truth.size(); ++pixel) {
      if (view.truth[pixel].meets != Meets::kSurface) continue;
      const auto column = static_cast<std::uint32_t>(pixel % view.size.width);
      const auto row = static_cast<std::uint32_t>(pixel / view.size.width);
      const double truth_mm = view.truth[pixel].depth_mm;
      errors_mm.push_back(std::abs(maps.smooth_mm[pixel] - truth_mm));
      const auto shown = normals.at(static_cast<int>(column), static_cast<int>(row));
      const glm::dvec3 known = surface.normal(view.rays.ray(column, row).at(truth_mm));
      errors_deg.push_back(degrees(std::acos(std::clamp(glm::dot(*shown, known), -1.0, 1.0))));
    }
    return {.normals_deg = quantile_90(std::move(errors_deg)),
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
