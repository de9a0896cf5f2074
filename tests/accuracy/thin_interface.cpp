// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/test_fans.hpp"

namespace fanlight::test {

namespace {

constexpr double kThicknessMm = 0.45;
constexpr double kThinDepthMm = 13.03;  // not on a sample
constexpr PictureSize kThinViewSize{128, 128};

/// As of a small motor-swept probe: pixels of 0.08 mm, a fan of 24 mm in depth.
TestFan fine_fan() {
  TestFan fan{"motor",
              {.kind = FrameKind::kCartesian,
               .columns = 240,
               .rows = 300,
               .pixel_width_mm = 0.08,
               .pixel_height_mm = 0.08,
               .face_column = 119.5,
               .face_row = 0,
               .motor_radius_mm = 12},
              {}};
  for (int frame = 0; frame < 61; ++frame) fan.angles_rad.push_back(radians(0.8 * (frame - 30)));
  return fan;
}

/// Errors of the shown depths in the middle of the picture, sorted, mm. Seen from the probe, the plane lies
/// at one depth below the view plane.
std::vector<double> thin_errors_mm(DepthRig& rig, const Scene& scene) {
  const std::vector<float> shown_mm = rig.depths(scene).smooth_mm;
  std::vector<double> errors;
  for (std::uint32_t row = kThinViewSize.height / 4; row < 3 * kThinViewSize.height / 4; ++row) {
    for (std::uint32_t column = kThinViewSize.width / 4; column < 3 * kThinViewSize.width / 4; ++column) {
      const double depth_mm = shown_mm[std::size_t{row} * kThinViewSize.width + column];
      errors.push_back(depth_mm < 0 ? HUGE_VAL : depth_mm - kThinDepthMm);
    }
  }
  std::ranges::sort(errors);
  return errors;
}

FigureRow thin_row(const std::string& name, DepthRig& rig, const Scene& scene, double demand_mm) {
  Scene at = scene;
  const auto median = [&](SurfacePlace place) {
    at.detector.place = place;
    const std::vector<double> errors = thin_errors_mm(rig, at);
    return errors[errors.size() / 2];
  };
  const std::vector<double> errors = thin_errors_mm(rig, scene);
  const auto missing = static_cast<double>(std::ranges::count(errors, HUGE_VAL));
  return {name,
          {{"front mm", std::abs(errors[errors.size() / 2]), 3, at_most(demand_mm)},
           {"5 % mm", errors[errors.size() / 20]},
           {"95 % mm", errors[errors.size() - 1 - errors.size() / 20]},
           {"missing %", 100 * missing / static_cast<double>(errors.size()), 2, at_most(1)},
           {"two scales mm", std::abs(median(SurfacePlace::kTwoScales)), 3, at_most(0.1)},
           {"refined mm", median(SurfacePlace::kRefined)},
           {"first crossing mm", median(SurfacePlace::kFirstCrossing)},
           {"ridge mm", median(SurfacePlace::kRidge) - kThicknessMm / 2}}};
}

}  // namespace

FigureBlock measure_thin_interface(const Workbench& bench) {
  FigureBlock block{"a thin bright interface",
                    "A plane of 0.45 mm (full width at half maximum) in fluid, seen from the probe by the "
                    "default scene, in\n"
                    "pixels of 0.08 mm. front: distance of the shown surface from the front half maximum, at "
                    "the median; 5 and\n"
                    "95 %: of the signed errors. Then the other places of a surface: from the front, and the "
                    "ridge from the\n"
                    "brightest line.",
                    {}};
  const TestFan fan = fine_fan();
  const KnownPlane plane({0, kThinDepthMm, 0}, 0, 0);
  KnownEcho echo = kLogEcho;
  echo.thickness_mm = kThicknessMm;
  const ScannedFan scanned = fan.scanned();
  for (const bool speckled : {false, true}) {
    const std::string name = speckled ? "thin/speckle" : "thin/clean";
    if (!bench.wants(name)) continue;
    const SpeckleField speckle = speckle_of(fan, 1);
    const Volume volume = swept(fan, plane, echo, speckled ? &speckle : nullptr);
    DepthRig rig(bench.gpu, scanned, static_cast<std::uint32_t>(fan.angles_rad.size()), kThinViewSize);
    rig.set_volume(volume);
    Scene scene =
        scene_for(scanned.geometry, scanned.first_angle_rad, scanned.last_angle_rad, kThinViewSize.height);
    bench.change(scene);
    block.rows.push_back(thin_row(name, rig, scene, 0.3));
  }
  return block;
}

}  // namespace fanlight::test
