// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/methods.hpp"

namespace fanlight::test {

void with_fixed_numbers(Scene& scene) {
  scene.detector = {};
  scene.detector.least_contrast = 1;
  scene.speckle = {};
}

namespace {

void with_paper_normals(Scene& scene) {
  with_fixed_numbers(scene);
  scene.light.normals = Normals::kThreeNeighbours;
}

void with_paper_filter(Scene& scene) {
  with_paper_normals(scene);
  scene.filter.kind = DepthFilter::kMean;
  scene.filter.weights = FilterWeights::kEven;
  scene.filter.islands = 1;
  scene.filter.holes = 1;
}

void without_preparation(Scene& scene) {
  with_paper_filter(scene);
  scene.speckle.filter = SpeckleFilter::kNone;
}

void paper(Scene& scene) {
  without_preparation(scene);
  scene.detector.place = SurfacePlace::kFirstCrossing;
}

void paper_with_its_window(Scene& scene) {
  paper(scene);
  scene.detector.window = 8;
}

constexpr Method kMethods[] = {
    {"paper", paper_with_its_window},
    {"+ window", paper},
    {"+ refined", without_preparation},
    {"+ pass 0", with_paper_filter},
    {"+ pass 2", with_paper_normals},
    {"+ normals", with_fixed_numbers},
    {"default (+ from the data)", [](Scene&) {}},
};

}  // namespace

std::span<const Method> methods() {
  return kMethods;
}

Scene cast_alone(Scene scene) {
  scene.detector.frame_steps = FrameSteps::kKept;
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.filter.size = 1;
  scene.filter.size_mm = 0;
  scene.filter.islands = 1;
  scene.filter.holes = 1;
  return scene;
}

}  // namespace fanlight::test
