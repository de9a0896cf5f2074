// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/test_fans.hpp"

namespace fanlight::test {

namespace {

/// A value of a number or choice field that differs from the present one.
double other_value(const SceneField& field, const Scene& scene) {
  return field.get(scene) == field.maximum ? field.minimum : field.maximum;
}

FigureRow relit_row(const std::string& name, DepthRig& rig, Scene scene) {
  scene.glass.amount = 0.5;  // to and from an opaque surface is a cast
  rig.depths(scene);
  const std::uint64_t before = rig.pass1_runs();
  int changed = 0;
  for (const SceneField& field : scene_fields()) {
    if (field.first_pass < FirstPass::kFilter || field.is_text()) continue;
    Scene relit = scene;
    field.set(relit, other_value(field, scene));
    rig.depths(relit);
    ++changed;
  }
  return {name,
          {{"fields changed", static_cast<double>(changed), 0, at_least(1)},
           {"pass 1 runs", static_cast<double>(rig.pass1_runs() - before), 0, at_most(0)}}};
}

}  // namespace

FigureBlock measure_relighting(const Workbench& bench) {
  FigureBlock block{"a moved light",
                    "Each field that pipelines 2 and 3 alone read is changed in turn; none may cast a ray.",
                    {}};
  const std::string name = "relight/every field";
  if (!bench.wants(name)) return block;
  const TestFan fan = test_fans().front();
  const ScannedFan scanned = fan.scanned();
  const Volume volume = swept(fan, *test_surfaces().back().surface, KnownEcho{}, nullptr);
  DepthRig rig(bench.gpu, scanned, static_cast<std::uint32_t>(fan.angles_rad.size()), {64, 64});
  rig.set_volume(volume);
  block.rows.push_back(
      relit_row(name, rig, scene_for(scanned.geometry, scanned.first_angle_rad, scanned.last_angle_rad)));
  return block;
}

}  // namespace fanlight::test
