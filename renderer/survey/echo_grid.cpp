// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/echo_grid.hpp"

#include <algorithm>
#include <cmath>

#include "proto/model/fan_sampler.hpp"

namespace fanlight {

namespace {

/// The mean of each value and its neighbours along a line of `count` values that are `stride` apart.
void smooth_line(float* values, std::size_t count, std::size_t stride) {
  float before = values[0];
  for (std::size_t at = 0; at < count; ++at) {
    float& here = values[at * stride];
    const bool is_last = at + 1 == count;
    const float next = is_last ? here : values[(at + 1) * stride];
    const float mean = (before + here + next) / 3;
    before = here;
    here = mean;
  }
}

}  // namespace

CellBox box_around(const Point& middle, double reach_mm, double step_mm) {
  const auto half = static_cast<std::uint32_t>(std::ceil(reach_mm / step_mm));
  const double reach = half * step_mm;
  return {.first = {middle.x_mm - reach, middle.y_mm - reach, middle.z_mm - reach},
          .step_mm = step_mm,
          .size = {2 * half + 1, 2 * half + 1, 2 * half + 1}};
}

double EchoGrid::level(double i, double j, double k) const {
  const auto cell = [](double at, std::uint32_t size) {
    return std::min(static_cast<std::uint32_t>(std::max(at, 0.0)), size - 2);
  };
  const std::uint32_t i0 = cell(i, box.size[0]);
  const std::uint32_t j0 = cell(j, box.size[1]);
  const std::uint32_t k0 = cell(k, box.size[2]);
  const std::size_t row = box.size[0];
  const std::size_t slice = row * box.size[1];
  const float* const corner = &levels[box.index(i0, j0, k0)];
  const auto along_i = [&](const float* from) { return std::lerp(double{from[0]}, double{from[1]}, i - i0); };
  const double near = std::lerp(along_i(corner), along_i(corner + row), j - j0);
  const double far = std::lerp(along_i(corner + slice), along_i(corner + slice + row), j - j0);
  return std::lerp(near, far, k - k0);
}

EchoGrid sampled(const Volume& volume, const CellBox& box) {
  EchoGrid grid{.box = box,
                .levels = std::vector<float>(box.cells()),
                .scanned = std::vector<std::uint8_t>(box.cells())};
  const FanSampler sampler(volume);
  std::size_t cell = 0;
  for (std::uint32_t k = 0; k < box.size[2]; ++k) {
    for (std::uint32_t j = 0; j < box.size[1]; ++j) {
      const Point row = box.centre(0, j, k);
      const FanCoordinate fan = volume.geometry().fan_coordinate(row.y_mm, row.z_mm);
      const auto frames = sampler.around(fan.angle_rad);
      for (std::uint32_t i = 0; i < box.size[0]; ++i, ++cell) {
        if (!frames) continue;
        const auto echo =
            sampler.echo(*frames, {.x_mm = row.x_mm + i * box.step_mm, .depth_mm = fan.depth_mm});
        if (!echo) continue;
        grid.levels[cell] = static_cast<float>(*echo);
        grid.scanned[cell] = 1;
      }
    }
  }
  return grid;
}

void smooth(EchoGrid& grid) {
  const auto [across, down, slices] = grid.box.size;
  for (std::uint32_t k = 0; k < slices; ++k)
    for (std::uint32_t j = 0; j < down; ++j) smooth_line(&grid.levels[grid.box.index(0, j, k)], across, 1);
  for (std::uint32_t k = 0; k < slices; ++k)
    for (std::uint32_t i = 0; i < across; ++i)
      smooth_line(&grid.levels[grid.box.index(i, 0, k)], down, across);
  for (std::uint32_t j = 0; j < down; ++j)
    for (std::uint32_t i = 0; i < across; ++i)
      smooth_line(&grid.levels[grid.box.index(i, j, 0)], slices, std::size_t{across} * down);
}

}  // namespace fanlight
