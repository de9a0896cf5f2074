// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "tests/accuracy/depth_errors.hpp"
#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/measurements.hpp"
#include "tests/accuracy/methods.hpp"
#include "tests/accuracy/phantom_truth.hpp"

namespace fanlight::test {

namespace {

constexpr PictureSize kSize{.width = 512, .height = 512};

std::unique_ptr<PhantomSource> phantom(PhantomSource::Speckle speckle) {
  return made_phantom(
      {.speckle = speckle, .motion = PhantomScene::Motion::kStill, .pace = PhantomSource::Pace::kUnpaced});
}

FigureRow phantom_row(const std::string& name, const DepthErrors& errors) {
  return {name,
          {{"median mm", errors.median_mm()},
           {"signed mm", errors.signed_median_mm()},
           {"95 % mm", errors.magnitude_mm(0.95)},
           {"found %", 100 * errors.share_found(), 2},
           {"false %", 100 * errors.share_false(), 2},
           {"missing %", 100 * errors.share_missing(), 2},
           {"behind %", 100 * errors.share_behind(), 2},
           {"rim found %", 100 * errors.share_of_rim_found(), 1},
           {"pixels", static_cast<double>(errors.surfaces()), 0}}};
}

/// The default picture of the phantom at rest, with the truth of each pixel.
class ReferenceWork {
 public:
  explicit ReferenceWork(const Workbench& bench)
      : still_(PhantomScene::Motion::kStill),
        surface_(still_),
        fan_{description_.geometry, description_.first_angle_rad, description_.last_angle_rad},
        scene_(scene_for(fan_.geometry, fan_.first_angle_rad, fan_.last_angle_rad)),
        rays_(scene_, kSize),
        truth_(depth_truth(rays_, kSize, fan_, surface_)),
        rig_(bench.gpu, fan_, description_.frames_per_volume, kSize) {
    bench.change(scene_);
  }

  DepthErrors errors(const Volume& volume, const Method& method) {
    Scene scene = scene_;
    method.change(scene);
    rig_.set_volume(volume);
    DepthErrors errors(Rim::kApart);
    errors.add(rig_.depths(scene).smooth_mm, truth_, rays_, kSize, surface_);
    return errors;
  }

 private:
  SourceDescription description_ = phantom(PhantomSource::Speckle::kOff)->description();
  PhantomScene still_;
  ReliefSurface surface_;
  ScannedFan fan_;
  Scene scene_;
  PixelRays rays_;
  std::vector<PixelTruth> truth_;
  DepthRig rig_;
};

}  // namespace

FigureBlock measure_reference_work(const Workbench& bench) {
  FigureBlock block{
      "the reference work (R1): the simulated probe's face, at rest",
      "35 frames of 512 x 512 over 70 deg, 160 mm deep, a beam of 5 mm in elevation, a picture of "
      "512 x 512 from the probe.\nNothing is demanded: the frames lie 4 mm apart at the surface, "
      "and its echo has a bright band behind it.",
      {}};
  std::optional<ReferenceWork> work;
  for (const auto speckle : {PhantomSource::Speckle::kOff, PhantomSource::Speckle::kOn}) {
    std::optional<Volume> volume;
    for (const Method& method : {methods()[kPaperMethod], methods().back()}) {
      const bool on = speckle == PhantomSource::Speckle::kOn;
      const std::string name = fmt::format("r1/speckle {}/{}", on ? "on" : "off", method.name);
      if (!bench.wants(name)) continue;
      if (!work) work.emplace(bench);
      if (!volume) volume = next_sweep(*phantom(speckle));
      block.rows.push_back(phantom_row(name, work->errors(*volume, method)));
    }
  }
  return block;
}

}  // namespace fanlight::test
