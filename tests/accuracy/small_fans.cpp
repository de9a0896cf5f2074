// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>

#include "tests/accuracy/depth_errors.hpp"
#include "tests/accuracy/depth_normals.hpp"
#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/known_views.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/methods.hpp"
#include "tests/accuracy/test_fans.hpp"

namespace fanlight::test {

namespace {

constexpr std::array kProjections = {Projection::kParallel, Projection::kPerspective};

std::string row_name(std::string_view block, const TestSurface& surface, const TestFan& fan,
                     Projection projection) {
  return fmt::format("{}/{}/{}/{}", block, surface.name, fan.name,
                     projection == Projection::kParallel ? "parallel" : "perspective");
}

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::ranges::nth_element(values, values.begin() + values.size() / 2);
  return values[values.size() / 2];
}

using Views = std::vector<KnownView>;
using Change = std::function<void(Scene&)>;

/// Errors of the depths of pass 1, over all views.
DepthErrors cast_errors(DepthRig& rig, const Views& views, const KnownSurface& surface,
                        const Change& change) {
  DepthErrors errors(Rim::kJudged);
  for (const KnownView& view : views) {
    Scene scene = cast_alone(view.scene);
    change(scene);
    errors.add(rig.depths(scene).cast_mm, view.truth, view.rays, view.size, surface);
  }
  return errors;
}

/// Range of the signed median error over thresholds of 0.1 to 0.6 of the contrast, mm.
double threshold_drift_mm(DepthRig& rig, const Views& views, const KnownSurface& surface,
                          SurfacePlace place) {
  double least_mm = HUGE_VAL;
  double most_mm = -HUGE_VAL;
  for (int tenths = 1; tenths <= 6; ++tenths) {
    const DepthErrors errors = cast_errors(rig, views, surface, [&](Scene& scene) {
      scene.detector.place = place;
      scene.detector.threshold = tenths / 10.0 * KnownEcho{}.contrast();
    });
    least_mm = std::min(least_mm, errors.signed_median_mm());
    most_mm = std::max(most_mm, errors.signed_median_mm());
  }
  return most_mm - least_mm;
}

FigureRow clean_row(const std::string& name, DepthRig& rig, const Views& views, const KnownSurface& surface) {
  constexpr double kWithinMm = 0.15;
  const auto at_place = [&](SurfacePlace place) {
    return cast_errors(rig, views, surface, [&](Scene& scene) { scene.detector.place = place; });
  };
  const DepthErrors refined = at_place(SurfacePlace::kRefined);
  const DepthErrors crossing = at_place(SurfacePlace::kFirstCrossing);
  const double drift_mm = threshold_drift_mm(rig, views, surface, SurfacePlace::kRefined);
  const double crossing_drift_mm = threshold_drift_mm(rig, views, surface, SurfacePlace::kFirstCrossing);
  return {name,
          {{"median mm", refined.median_mm(), 3, at_most(0.05)},
           {"within .15 %", 100 * refined.share_within(kWithinMm), 1, at_least(95)},
           {"drift mm", drift_mm, 3, at_most(0.05)},
           {"signed mm", refined.signed_median_mm()},
           {"missing %", 100 * refined.share_missing(), 2},
           {"false %", 100 * refined.share_false(), 2},
           {"first: median mm", crossing.median_mm()},
           {"first: within .15 %", 100 * crossing.share_within(kWithinMm), 1},
           {"first: drift mm", crossing_drift_mm},
           {"pixels", static_cast<double>(refined.surfaces()), 0}}};
}

/// Errors of the final depths and normals, over all views.
struct Shown {
  DepthErrors errors{Rim::kApart};
  std::vector<double> normals_deg;

  void add(DepthRig& rig, const KnownView& view, const Scene& scene, const KnownSurface& surface) {
    const DepthMaps depths = rig.depths(scene);
    errors.add(depths.smooth_mm, view.truth, view.rays, view.size, surface);
    const DepthNormals normals(depths.smooth_mm, view.size, view.rays, scene.light.normals,
                               scene.filter.step_mm);
    const auto errors_deg =
        normal_errors_deg(normals, depths.smooth_mm, view.truth, view.rays, view.size, surface);
    normals_deg.insert(normals_deg.end(), errors_deg.begin(), errors_deg.end());
  }
};

double normals_deg(DepthRig& rig, const Views& views, const KnownSurface& surface, const Change& change) {
  Shown shown;
  for (const KnownView& view : views) {
    Scene scene = view.scene;
    change(scene);
    shown.add(rig, view, scene, surface);
  }
  return median(std::move(shown.normals_deg));
}

FigureRow normals_row(const std::string& name, DepthRig& rig, const Views& views,
                      const KnownSurface& surface) {
  const auto measured = [&](Normals kind, bool filtered) {
    return normals_deg(rig, views, surface, [&](Scene& scene) {
      if (!filtered) scene = cast_alone(scene);
      scene.light.normals = kind;
    });
  };
  return {name,
          {{"central deg", measured(Normals::kCentral, true), 2, at_most(1.4)},
           {"three deg", measured(Normals::kThreeNeighbours, true), 2},
           {"raw: central deg", measured(Normals::kCentral, false), 2},
           {"raw: three deg", measured(Normals::kThreeNeighbours, false), 2}}};
}

/// The figures of every method, besides those with a demand for the default scene.
std::vector<Figure> figures_next_to(const Shown& shown) {
  const DepthErrors& errors = shown.errors;
  return {{"signed mm", errors.signed_median_mm()},
          {"95 % mm", errors.magnitude_mm(0.95)},
          {"missing %", 100 * errors.share_missing(), 2},
          {"behind %", 100 * errors.share_behind(), 2},
          {"in tissue %", 100 * errors.share_shown_in_tissue(), 1},
          {"rim found %", 100 * errors.share_of_rim_found(), 1},
          {"all: found %", 100 * errors.share_found_of_all(), 2},
          {"all: false %", 100 * errors.share_false_of_all(), 2},
          {"normals deg", median(shown.normals_deg), 1}};
}

FigureRow shown_row(const std::string& name, const Shown& shown, std::vector<Figure> first) {
  std::ranges::copy(figures_next_to(shown), std::back_inserter(first));
  return {name, std::move(first)};
}

FigureRow speckle_row(const std::string& name, DepthRig& rig, const Views& views,
                      const KnownSurface& surface) {
  Shown shown;
  for (const KnownView& view : views) shown.add(rig, view, view.scene, surface);
  const DepthErrors& errors = shown.errors;
  return shown_row(name, shown,
                   {{"median mm", errors.median_mm(), 3, at_most(0.5)},
                    {"found %", 100 * errors.share_found(), 2, at_least(99)},
                    {"false %", 100 * errors.share_false(), 2, at_most(0.5)}});
}

FigureRow linear_row(const std::string& name, DepthRig& rig, const Views& views,
                     const KnownSurface& surface) {
  Views fixed = views;
  for (KnownView& view : fixed) with_fixed_numbers(view.scene);
  FigureRow row = speckle_row(name, rig, fixed, surface);
  Shown shown;
  for (const KnownView& view : views) shown.add(rig, view, view.scene, surface);
  row.figures.push_back({"default: median mm", shown.errors.median_mm()});
  row.figures.push_back({"default: signed mm", shown.errors.signed_median_mm()});
  return row;
}

FigureRow method_row(const std::string& name, const Shown& shown) {
  const DepthErrors& errors = shown.errors;
  return shown_row(name, shown,
                   {{"median mm", errors.median_mm()},
                    {"found %", 100 * errors.share_found(), 2},
                    {"false %", 100 * errors.share_false(), 2}});
}

std::string method_name(const Method& method) {
  return fmt::format("method/{}", method.name);
}

constexpr char kCleanLegend[] =
    R"(Pipelines 0 and 2 off, detector as in the default scene. Two views a row: from the probe, and yaw 20, pitch -15, roll 30.
Errors are shown - true depth along the view axis, of every pixel whose true surface lies 5 mm or more inside the fan;
for median and within, what is not shown is infinitely wrong.
drift: how far the signed median moves over thresholds of 0.1, 0.2, ... 0.6 of the contrast.
first: the paper's place of the surface, where the threshold is first crossed.)";

constexpr char kNormalsLegend[] =
    R"(Median angle between shown and true normal, from differences to both sides (central) or to one (three neighbours).
raw: of the depth map as it was cast, pipelines 0 and 2 off.)";

constexpr char kSpeckleLegend[] =
    R"(Rayleigh speckle in grains of 0.5 mm along the lines, 1 mm across and 2 mm in elevation, log-compressed: 60 dB from
black to white, tissue 35 dB above the fluid; the grey levels' edge is blurred as without speckle. Views and errors as above, but
apart from the rim: surfaces that the ray grazes at more than 75 deg to their normal.
found: shown within 1.5 mm of the true depth. missing: not shown. behind: shown more than 1.5 mm too deep.
false: shown more than 1.5 mm in front of the true surface, or, on a ray through fluid alone, more than 1.5 mm from any
surface; of the rays that meet the surface or fluid alone.
in tissue: a surface shown on a ray that enters the fan within tissue, its cut side, of all such rays; not part of false.
all: found and false with the rim and with the rays that enter the fan within tissue. - where there is nothing to judge.)";

constexpr char kLinearLegend[] =
    R"(As before, with grey levels proportional to the echo, and the numbers that theory has for them: a deviation of 0.52 of
the mean, a window of 28 samples, threshold 20, the steepest point. default: by the default scene, which measures.)";

constexpr char kStepsLegend[] =
    R"(All rows of the block before together. paper: first crossing with a window of 8, mean filter of the default scene's size,
normals from three neighbours, and neither pass 0 nor weights nor cleaning. Each step adds to the one before, first the
default scene's window: the crossing drifts with it.)";

/// The sweeps of a fan over a surface, generated at the first access.
class Sweeps {
 public:
  Sweeps(const TestFan& fan, const KnownSurface& surface, const SpeckleField& speckle)
      : fan_(fan), surface_(surface), speckle_(speckle) {}

  const Volume& clean() {
    if (!clean_) clean_ = swept(fan_, surface_, KnownEcho{}, nullptr);
    return *clean_;
  }
  const Volume& speckled() {
    if (!speckled_) speckled_ = swept(fan_, surface_, kLogEcho, &speckle_);
    return *speckled_;
  }
  const Volume& linear() {
    if (!linear_) linear_ = swept(fan_, surface_, KnownEcho{}, &speckle_);
    return *linear_;
  }

 private:
  const TestFan& fan_;
  const KnownSurface& surface_;
  const SpeckleField& speckle_;
  std::optional<Volume> clean_;
  std::optional<Volume> speckled_;
  std::optional<Volume> linear_;
};

/// Collects the rows of the blocks, fan by fan and surface by surface.
class SmallFans {
 public:
  explicit SmallFans(const Workbench& bench) : bench_(bench), methods_(methods().size()) {}

  void measure(const TestFan& fan) {
    DepthRig rig(bench_.gpu, fan.scanned(), static_cast<std::uint32_t>(fan.angles_rad.size()), kViewSize);
    const SpeckleField speckle = speckle_of(fan, 1);
    for (const TestSurface& surface : test_surfaces()) {
      Sweeps sweeps(fan, *surface.surface, speckle);
      for (const Projection projection : kProjections) measure(rig, fan, surface, sweeps, projection);
    }
  }

  std::vector<FigureBlock> blocks() &&;

 private:
  void measure(DepthRig& rig, const TestFan& fan, const TestSurface& surface, Sweeps& sweeps,
               Projection projection);
  void add_methods(DepthRig& rig, const Views& views, const KnownSurface& surface);
  bool wants_method(const Method& method) const { return bench_.wants(method_name(method)); }

  const Workbench& bench_;
  FigureBlock clean_{"depth, no speckle: pass 1 alone", kCleanLegend, {}};
  FigureBlock normals_{"normals, no speckle: default scene", kNormalsLegend, {}};
  FigureBlock speckled_{"depth, speckle: default scene", kSpeckleLegend, {}};
  FigureBlock linear_{"depth, speckle that is not log-compressed: fixed numbers", kLinearLegend, {}};
  FigureBlock steps_{"depth, speckle: from the paper's method to the default scene", kStepsLegend, {}};
  std::vector<Shown> methods_;  // one for each of methods()
};

void SmallFans::measure(DepthRig& rig, const TestFan& fan, const TestSurface& surface, Sweeps& sweeps,
                        Projection projection) {
  const std::string clean = row_name("clean", surface, fan, projection);
  const std::string normals = row_name("normals", surface, fan, projection);
  const std::string speckled = row_name("speckle", surface, fan, projection);
  const std::string linear = row_name("linear", surface, fan, projection);
  const bool wants_linear =
      fan.name == "cartesian" && projection == Projection::kParallel && bench_.wants(linear);
  const bool wants_normals = surface.name == "sphere" && bench_.wants(normals);
  const bool wants_methods =
      std::ranges::any_of(methods(), [&](const Method& method) { return wants_method(method); });
  if (!bench_.wants(clean) && !wants_normals && !bench_.wants(speckled) && !wants_linear && !wants_methods)
    return;

  Views views = known_views(fan.scanned(), *surface.surface, projection);
  for (KnownView& view : views) {
    // These edges are blurred after the compression, so that no decibels say where they are.
    view.scene.detector.rise = 0.65;
    view.scene.detector.reach = 0;
    bench_.change(view.scene);
  }
  if (bench_.wants(clean) || wants_normals) rig.set_volume(sweeps.clean());
  if (bench_.wants(clean)) clean_.rows.push_back(clean_row(clean, rig, views, *surface.surface));
  if (wants_normals) normals_.rows.push_back(normals_row(normals, rig, views, *surface.surface));
  if (bench_.wants(speckled) || wants_methods) rig.set_volume(sweeps.speckled());
  if (bench_.wants(speckled)) speckled_.rows.push_back(speckle_row(speckled, rig, views, *surface.surface));
  add_methods(rig, views, *surface.surface);
  if (wants_linear) {
    rig.set_volume(sweeps.linear());
    linear_.rows.push_back(linear_row(linear, rig, views, *surface.surface));
  }
}

void SmallFans::add_methods(DepthRig& rig, const Views& views, const KnownSurface& surface) {
  for (std::size_t step = 0; step < methods_.size(); ++step) {
    if (!wants_method(methods()[step])) continue;
    for (const KnownView& view : views) {
      Scene scene = view.scene;
      methods()[step].change(scene);
      methods_[step].add(rig, view, scene, surface);
    }
  }
}

std::vector<FigureBlock> SmallFans::blocks() && {
  for (std::size_t step = 0; step < methods_.size(); ++step) {
    if (!wants_method(methods()[step])) continue;
    steps_.rows.push_back(method_row(method_name(methods()[step]), methods_[step]));
  }
  return {std::move(clean_), std::move(normals_), std::move(speckled_), std::move(linear_),
          std::move(steps_)};
}

}  // namespace

std::vector<FigureBlock> measure_small_fans(const Workbench& bench) {
  SmallFans fans(bench);
  for (const TestFan& fan : test_fans()) fans.measure(fan);
  return std::move(fans).blocks();
}

}  // namespace fanlight::test
