// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "tests/accuracy/depth_errors.hpp"
#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/known_views.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/scanned_frames.hpp"
#include "tests/accuracy/test_fans.hpp"
#include "tests/support/scanner_echo.hpp"

namespace fanlight::test {

namespace {

/// Signed errors of what is shown, mm, and the numbers of pixels.
struct Judged {
  std::vector<double> errors_mm;
  std::size_t surface = 0;       // rays that meet the true surface less than kRimDeg from a right angle
  std::size_t within = 0;        // of those, shown within 0.5 mm
  std::size_t shown = 0;         // of all rays that meet surface or fluid
  std::size_t shown_within = 0;  // of those

  void add(std::span<const float> shown_mm, std::span<const PixelTruth> truth) {
    constexpr double kWithinMm = 0.5;
    for (std::size_t pixel = 0; pixel < truth.size(); ++pixel) {
      const PixelTruth& at = truth[pixel];
      const bool is_surface = at.meets == Meets::kSurface && at.incidence_deg < kRimDeg;
      if (!is_surface && at.meets != Meets::kFluid) continue;
      surface += is_surface ? 1 : 0;
      if (shown_mm[pixel] < 0) continue;
      ++shown;
      if (!is_surface) continue;
      errors_mm.push_back(shown_mm[pixel] - at.depth_mm);
      if (std::abs(errors_mm.back()) > kWithinMm) continue;
      ++within;
      ++shown_within;
    }
  }
  double signed_median_mm() {
    if (errors_mm.empty()) return NAN;
    std::ranges::nth_element(errors_mm,
                             errors_mm.begin() + static_cast<std::ptrdiff_t>(errors_mm.size() / 2));
    return errors_mm[errors_mm.size() / 2];
  }
};

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? NAN : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

constexpr char kLegend[] =
    R"(Frames as a scanner makes them: the amplitude of the echo is blurred by the pulse and by a beam with a width in the
frame and across it, with side lobes of -32 dB and reverberation below the probe, multiplied by speckle, with the
receiver's noise, and log-compressed. From the probe, default scene.
signed: median of shown - true depth. of shown, of true: within 0.5 mm, of what is shown on rays that meet surface or fluid,
and of the true surface that is met at less than 75 deg. empty: shown on all rays, where there is no surface at all.)";

class ScannedScenes {
 public:
  explicit ScannedScenes(const Workbench& bench) : bench_(bench) {}

  void measure(const TestFan& fan) {
    grains_.clear();
    for (const Scanner& scanner : scanners()) {
      for (const TestSurface& surface : test_surfaces()) measure(fan, scanner, surface);
      // Of 7 mm, about the size of a finger.
      measure(fan, scanner, {"ball", std::make_unique<KnownSphere>(glm::dvec3(1.7, 38.3, -1.1), 3.5)});
      for (const double thickness_mm : {0.3, 0.6, 1.0}) measure_sheet(fan, scanner, thickness_mm);
      measure_empty(fan, scanner);
    }
  }

  FigureBlock block{"depth, scanned: default scene", kLegend, {}};

 private:
  void measure(const TestFan& fan, const Scanner& scanner, const TestSurface& surface) {
    const std::string name = fmt::format("scanned/{}/{}/{}", scanner.name, surface.name, fan.name);
    if (!bench_.wants(name)) return;
    add(name, fan, *surface.surface, scanned(fan, *surface.surface, scanner.echo, grains(fan, 3)));
  }

  void measure_sheet(const TestFan& fan, const Scanner& scanner, double thickness_mm) {
    const std::string name = fmt::format("scanned/{}/sheet-{:.1f}/{}", scanner.name, thickness_mm, fan.name);
    if (!bench_.wants(name)) return;
    ScannerEcho echo = scanner.echo;
    echo.thickness_mm = thickness_mm;
    const KnownPlane plane({0.07, kSurfaceDepthMm + 0.11, -0.05}, 10, 5);
    add(name, fan, plane, scanned(fan, plane, echo, grains(fan, 3)));
  }

  const Grains& grains(const TestFan& fan, std::uint64_t seed) {
    return grains_.try_emplace(seed, fan, seed).first->second;
  }

  DepthRig new_rig(const TestFan& fan) const {
    // What is known of another volume's levels outlasts it.
    return DepthRig(bench_.gpu, fan.scanned(), static_cast<std::uint32_t>(fan.angles_rad.size()), kViewSize);
  }

  void add(const std::string& name, const TestFan& fan, const KnownSurface& surface, const Volume& volume) {
    DepthRig rig = new_rig(fan);
    KnownView view = view_from_probe(fan.scanned(), surface, Projection::kParallel);
    bench_.change(view.scene);
    rig.set_volume(volume);
    Judged judged;
    judged.add(rig.depths(view.scene).smooth_mm, view.truth);
    const double signed_mm = judged.signed_median_mm();
    // Thin sheets under a broad beam, or thinner than the pulse, are not there yet: renderer/RESULTS.md.
    const auto has = [&name](std::string_view part) { return name.find(part) != std::string::npos; };
    const bool is_placed = !has("sheet-0.3") && !(has("sheet") && has("broad-beam"));
    const auto median = is_placed ? std::optional(at_most(has("ball") ? 0.4 : 0.25)) : std::nullopt;
    // Of a sphere the slanted sides, too.
    const bool is_broad = has("broad-beam");
    const double least = has("ball") ? (is_broad ? 55 : 75) : has("sphere") ? (is_broad ? 60 : 75) : 95;
    const auto within = is_placed ? std::optional(at_least(least)) : std::nullopt;
    // What is shown beside a ball's outline is as large as the ball.
    const auto of_shown = has("ball") ? std::nullopt : within;
    block.rows.push_back(
        {name, with_levels(rig, {{"signed mm", signed_mm},
                                 {"off mm", std::abs(signed_mm), 3, median},
                                 {"of shown %", share(judged.shown_within, judged.shown), 1, of_shown},
                                 {"of true %", share(judged.within, judged.surface), 1, within}})});
  }

  static std::vector<Figure> with_levels(const DepthRig& rig, std::vector<Figure> figures) {
    const EchoLevels& levels = rig.picture().stamp.levels;
    figures.push_back({"fluid", levels.fluid, 0});
    figures.push_back({"tissue", levels.tissue, 0});
    figures.push_back({"speckle", levels.noise, 1});
    figures.push_back({"rise", levels.rise(0.6), 2});
    return figures;
  }

  /// The receiver's noise alone; and tissue without a border.
  void measure_empty(const TestFan& fan, const Scanner& scanner) {
    for (const bool is_tissue : {false, true}) {
      const std::string name =
          fmt::format("scanned/{}/{}/{}", scanner.name, is_tissue ? "tissue-alone" : "noise-alone", fan.name);
      if (!bench_.wants(name)) continue;
      // So much gain that the noise is seen.
      ScannerEcho echo = scanner.echo;
      if (!is_tissue) echo.tissue_grey += 90;
      const Volume volume = scanned(
          fan, [&](const glm::dvec3&, const BeamAxes&, double) { return is_tissue ? 1.0 : 0.0; }, echo,
          grains(fan, 5));
      const KnownPlane none({0, 1000, 0}, 0, 0);
      KnownView view = view_from_probe(fan.scanned(), none, Projection::kParallel);
      bench_.change(view.scene);
      DepthRig rig = new_rig(fan);
      rig.set_volume(volume);
      // The reverberation's own end is an edge, from bright to dark: in the noise, or 10 dB below the tissue.
      const double falls_db = echo.reverberation_db - (is_tissue ? -10 : echo.noise_db);
      const KnownPlane its_end({0, falls_db / echo.reverberation_db_per_mm, 0}, 0, 0);
      const KnownView beyond = view_from_probe(fan.scanned(), its_end, Projection::kParallel);
      const auto shown_percent = [&](const Scene& scene) {
        const std::vector<float> shown_mm = rig.depths(scene).cast_mm;
        std::size_t in_fan = 0;
        std::size_t shown = 0;
        for (std::size_t pixel = 0; pixel < view.truth.size(); ++pixel) {
          if (view.truth[pixel].meets == Meets::kNothing) continue;
          ++in_fan;
          const bool either = scene.detector.sign == EdgeSign::kEither;
          if (shown_mm[pixel] >= (either ? beyond.truth[pixel].depth_mm : 0)) ++shown;
        }
        return share(shown, in_fan);
      };
      Scene by_hand = view.scene;
      by_hand.detector.threshold = 5;
      Scene raw = by_hand;
      raw.speckle.filter = SpeckleFilter::kNone;
      // As in volumes with a surface, whose levels are known.
      Scene reduced = by_hand;
      reduced.speckle.noise = 0;
      const auto most_percent = [&](Scene scene) {
        double most = 0;
        for (const SurfacePlace place : {SurfacePlace::kFirstCrossing, SurfacePlace::kRefined,
                                         SurfacePlace::kTwoScales, SurfacePlace::kRidge}) {
          scene.detector.place = place;
          most = std::max(most, shown_percent(scene));
        }
        scene.detector.place = SurfacePlace::kLevel;
        scene.detector.sign = EdgeSign::kEither;
        return std::max(most, shown_percent(scene));
      };
      Scene every_edge = by_hand;
      every_edge.detector.least_contrast = 1;
      const double shown = shown_percent(view.scene);
      reduced.speckle.levels = rig.picture().stamp.levels.noise;
      block.rows.push_back(
          {name, with_levels(rig, {{"empty %", shown, 1, at_most(0.5)},
                                   {"by hand %", shown_percent(by_hand), 1, at_most(0.5)},
                                   {"places %", most_percent(by_hand), 1, at_most(0.5)},
                                   {"reduced %", shown_percent(reduced), 1, at_most(0.5)},
                                   {"raw %", shown_percent(raw), 1, at_most(0.5)},
                                   {"every edge %", shown_percent(every_edge), 1},
                                   {"flat", rig.picture().stamp.levels.flat ? 1.0 : 0.0, 0, at_least(1)}})});
    }
  }

  const Workbench& bench_;
  std::map<std::uint64_t, Grains> grains_;  // of the fan that is measured, by seed
};

}  // namespace

FigureBlock measure_scanned_scenes(const Workbench& bench) {
  ScannedScenes scenes(bench);
  for (const TestFan& fan : test_fans())
    if (fan.name != "linear") scenes.measure(fan);
  return std::move(scenes.block);
}

}  // namespace fanlight::test
