// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/effective_scene.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight {

namespace {

// The ranges of speckle.size and filter.size.
constexpr int kLeastSpeckle = 3;
constexpr int kMostSpeckle = 7;
constexpr int kMostFilter = 31;
// From this window on, the detector's means are of four samples, as in EchoLevels::least_contrast().
constexpr int kFullMeansWindow = 8;

/// The odd number of pixels nearest to a length, limited.
int odd_pixels(double length_mm, double pixel_mm, int least, int most) {
  const double radius = std::clamp(length_mm / pixel_mm, 0.0, 1e6) / 2;
  return std::clamp(2 * static_cast<int>(std::lround(radius - 0.5)) + 1, least, most);
}

/// The window of a finer picture that covers the same length.
int finer(int window, double pixels_per_pixel) {
  const int radius = window / 2;
  return 2 * static_cast<int>(std::lround(radius * pixels_per_pixel)) + 1;
}

/// The even number of samples nearest to a length, limited.
int even_samples(double length_mm, double step_mm) {
  return std::clamp(2 * static_cast<int>(std::lround(length_mm / step_mm / 2)), 2, kMostDetectorWindow);
}

/// Whether a filter reduces speckle of these levels: its window is not the smallest, and its noise is not set
/// far below theirs.
bool reduces_speckle(const Scene::Speckle& speckle, const EchoLevels& levels) {
  constexpr double kLeastShare = 0.7;
  if (speckle.filter == SpeckleFilter::kNone || speckle.size == kLeastSpeckle) return false;
  if (speckle.filter != SpeckleFilter::kGuided) return true;
  const double removed = speckle.noise > 0 ? speckle.noise * levels.tissue : speckle.levels;
  return removed >= kLeastShare * levels.noise;
}

void take_noise(Scene::Speckle& speckle, const EchoLevels& levels) {
  if (speckle.filter != SpeckleFilter::kGuided || speckle.noise > 0 || speckle.levels > 0) return;
  if (!levels.known) {
    speckle.noise = Scene::Speckle{}.noise;
  } else if (levels.linear()) {
    speckle.noise = levels.noise / levels.tissue;
  } else {
    speckle.levels = levels.noise;
  }
}

}  // namespace

Scene effective_scene(const Scene& scene, const FanGeometry& geometry, PictureSize usual,
                      const EchoLevels& levels) {
  Scene made = scene;
  const PictureSize size = size_of(scene, usual);
  const double pixels_per_pixel = static_cast<double>(size.height) / usual.height;
  made.size = size;
  if (scene.detector.window_mm > 0) {
    const double finest_mm =
        std::max(geometry.finest_mm(), (scene.rays.end_mm - scene.rays.start_mm) / (kMostSamplesOnARay - 1));
    made.rays.step_mm = sample_step_mm(scene, finest_mm);
    made.detector.window = even_samples(scene.detector.window_mm, made.rays.step_mm);
  }
  if (scene.speckle.size_mm > 0)
    made.speckle.size =
        odd_pixels(scene.speckle.size_mm, geometry.pixel_height_mm, kLeastSpeckle, kMostSpeckle);
  made.filter.size = scene.filter.size_mm > 0
                         ? odd_pixels(scene.filter.size_mm, viewport(scene, size).pixel_mm, 1,
                                      finer(kMostFilter, pixels_per_pixel))
                         : finer(scene.filter.size, pixels_per_pixel);
  made.filter.islands = finer(scene.filter.islands, pixels_per_pixel);
  made.filter.holes = finer(scene.filter.holes, pixels_per_pixel);
  take_noise(made.speckle, levels);
  if (scene.detector.threshold == 0)
    made.detector.threshold = levels.known || levels.flat ? levels.threshold() : Scene::Detector{}.threshold;
  // How far a slow rise reaches was measured in decibels.
  if (!levels.in_decibels()) made.detector.reach = 0;
  if (scene.detector.rise == 0) made.detector.rise = levels.rise(made.detector.reach);
  if (scene.detector.sheet_below == 0) made.detector.sheet_below = levels.sheet_below();
  if (scene.detector.least_tissue == 0) made.detector.least_tissue = levels.least_tissue();
  if (scene.detector.least_contrast == 0) {
    const bool reduced = made.detector.window >= kFullMeansWindow && reduces_speckle(made.speckle, levels);
    made.detector.least_contrast = levels.least_contrast(reduced);
  }
  // What is not different must compare as equal.
  made.detector.window_mm = made.speckle.size_mm = made.filter.size_mm = 0;
  return made;
}

}  // namespace fanlight
