// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "tests/support/cpu_twin.hpp"

namespace fanlight::test {

namespace {

/// One value a voxel: frame by ascending angle, row, column.
struct Voxels {
  int columns;
  int rows;
  int frames;
  bool masked;  ///< FanGeometry::zero_is_unscanned
  std::vector<double> value;

  bool is_scanned(double grey) const { return !masked || grey > 0; }

  std::size_t index(int column, int row, int frame) const {
    return (static_cast<std::size_t>(frame) * static_cast<std::size_t>(rows) +
            static_cast<std::size_t>(row)) *
               static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
};

Voxels voxels_of(const Volume& volume) {
  const FanGeometry& geometry = volume.geometry();
  Voxels voxels{.columns = static_cast<int>(geometry.columns),
                .rows = static_cast<int>(geometry.rows),
                .frames = static_cast<int>(volume.by_angle().size()),
                .masked = geometry.zero_is_unscanned,
                .value = {}};
  for (const std::uint32_t frame : volume.by_angle()) {
    const auto pixels = volume.frame_pixels(frame);
    voxels.value.insert(voxels.value.end(), pixels.begin(), pixels.end());
  }
  return voxels;
}

/// Sets each voxel to reduce(values of its window). The window is clipped to the volume. `counts`: the values
/// that count, those that are_scanned() in it.
template <typename Reduce>
Voxels over_windows(const Scene::Speckle& speckle, const Voxels& from, const Voxels& counts, Reduce reduce) {
  const int radius = speckle.size / 2;
  const int across = speckle.across / 2;
  Voxels to = from;
  std::vector<double> window;
  for (int frame = 0; frame < from.frames; ++frame) {
    for (int row = 0; row < from.rows; ++row) {
      for (int column = 0; column < from.columns; ++column) {
        window.clear();
        for (int z = std::max(0, frame - across); z <= std::min(from.frames - 1, frame + across); ++z) {
          for (int y = std::max(0, row - radius); y <= std::min(from.rows - 1, row + radius); ++y) {
            for (int x = std::max(0, column - radius); x <= std::min(from.columns - 1, column + radius);
                 ++x) {
              const std::size_t at = from.index(x, y, z);
              if (counts.is_scanned(counts.value[at])) window.push_back(from.value[at]);
            }
          }
        }
        to.value[to.index(column, row, frame)] = window.empty() ? 0 : reduce(window);
      }
    }
  }
  return to;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// The median; of an even number of values the lower median.
double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The fraction of the variance of a window that is not speckle (Lee 1980), coefficient a of guided_fit.comp.
/// `noise`: standard deviation of speckle over its mean; `levels`: of speckle that is added, in grey levels.
double edge_fraction(const std::vector<double>& values, double noise, double levels) {
  const double middle = mean(values);
  double variance = 0;
  for (const double value : values) variance += (value - middle) * (value - middle);
  variance /= static_cast<double>(values.size());
  const double speckle_variance = noise * middle * noise * middle + levels * levels;
  return variance > 0 ? std::max(0.0, 1 - speckle_variance / variance) : 0;
}

/// The guided filter with Lee's coefficients: a line a * grey + b in each window. A voxel gets the mean of
/// the lines of all windows that contain it.
Voxels guided(const Scene::Speckle& speckle, const Voxels& grey) {
  const Voxels a = over_windows(speckle, grey, grey, [&](const auto& all) {
    return edge_fraction(all, speckle.noise, speckle.levels);
  });
  Voxels b = over_windows(speckle, grey, grey, mean);
  for (std::size_t at = 0; at < b.value.size(); ++at) b.value[at] *= 1 - a.value[at];

  // Windows in the middle of which nothing was scanned have lines, too.
  Voxels all = grey;
  all.masked = false;
  Voxels filtered = over_windows(speckle, a, all, mean);
  const Voxels offset = over_windows(speckle, b, all, mean);
  for (std::size_t at = 0; at < grey.value.size(); ++at) {
    filtered.value[at] = filtered.value[at] * grey.value[at] + offset.value[at];
  }
  return filtered;
}

Voxels filtered(const Scene::Speckle& speckle, const Voxels& grey) {
  switch (speckle.filter) {
    case SpeckleFilter::kNone:
      return grey;
    case SpeckleFilter::kBox:
      return over_windows(speckle, grey, grey, mean);
    case SpeckleFilter::kMedian:
      return over_windows(speckle, grey, grey, median);
    case SpeckleFilter::kGuided:
      return guided(speckle, grey);
  }
  return grey;
}

}  // namespace

Volume twin_prepare(const Scene::Speckle& speckle, const Volume& volume) {
  const Voxels before = voxels_of(volume);
  const Voxels grey = filtered(speckle, before);
  const auto order = volume.by_angle();
  Volume prepared(volume.geometry(), volume.frame_capacity());
  for (std::uint32_t frame = 0; frame < volume.stamp().frames; ++frame) {
    const auto position = static_cast<std::size_t>(std::ranges::find(order, frame) - order.begin());
    const auto pixels = prepared.next_frame_pixels();
    for (std::size_t at = 0; at < pixels.size(); ++at) {
      const std::size_t voxel = position * pixels.size() + at;
      pixels[at] = static_cast<std::uint8_t>(std::floor(grey.value[voxel] + 0.5));
      if (!before.masked) continue;
      pixels[at] = before.value[voxel] > 0 ? std::max<std::uint8_t>(pixels[at], 1) : 0;
    }
    prepared.add_frame({.angle_rad = volume.angles_rad()[frame]});
  }
  prepared.stamp() = volume.stamp();
  prepared.sort_by_angle();
  return prepared;
}

}  // namespace fanlight::test
