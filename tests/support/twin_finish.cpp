// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "renderer/parameters/light_parameters.hpp"
#include "tests/support/cpu_twin.hpp"

namespace fanlight::test {

namespace {

double luminance(const Rgb& colour) {
  return glm::dot(colour, Rgb(0.2126, 0.7152, 0.0722));
}

/// A picture whose border pixels are repeated outside it.
struct Pixels {
  const std::vector<Rgb>& colour;
  int width;
  int height;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(std::clamp(row, 0, height - 1) * width +
                                    std::clamp(column, 0, width - 1));
  }
  const Rgb& at(int column, int row) const { return colour[index(column, row)]; }
};

/// The mean of each pixel with its right, lower and lower right neighbours.
std::vector<Rgb> mean_of_four(const Pixels& from) {
  std::vector<Rgb> to;
  for (int row = 0; row < from.height; ++row) {
    for (int column = 0; column < from.width; ++column) {
      to.push_back(0.25 * (from.at(column, row) + from.at(column + 1, row) + from.at(column, row + 1) +
                           from.at(column + 1, row + 1)));
    }
  }
  return to;
}

/// One step of the diffusion (diffuse.comp): the flow falls where the step in brightness exceeds the
/// conductance. At the border a pixel is its own neighbour, so nothing flows across it.
std::vector<Rgb> diffused_once(const Pixels& from, double conductance) {
  std::vector<Rgb> to;
  for (int row = 0; row < from.height; ++row) {
    for (int column = 0; column < from.width; ++column) {
      const Rgb& here = from.at(column, row);
      Rgb inflow(0);
      for (const auto& [right, down] :
           {std::array{1, 0}, std::array{-1, 0}, std::array{0, 1}, std::array{0, -1}}) {
        const Rgb& there = from.at(column + right, row + down);
        const double step = (luminance(there) - luminance(here)) / conductance;
        inflow += (there - here) / (1 + step * step);
      }
      to.push_back(here + 0.2 * inflow);
    }
  }
  return to;
}

std::vector<Rgb> smoothed(std::vector<Rgb> colour, PictureSize size, const Scene::Finish& finish) {
  const int width = static_cast<int>(size.width);
  const int height = static_cast<int>(size.height);
  if (finish.smoothing == Smoothing::kMean) return mean_of_four({colour, width, height});
  if (finish.smoothing == Smoothing::kDiffusion) {
    for (int done = 0; done < finish.iterations; ++done) {
      colour = diffused_once({colour, width, height}, finish.conductance / 255);
    }
  }
  return colour;
}

/// The colour of a brightness: linear between four points at equal distances.
Rgb mapped(ColourMap colours, double brightness) {
  const auto points = colour_map_points(colours);
  const double position = 3 * std::clamp(brightness, 0.0, 1.0);
  const std::size_t below = std::min(static_cast<std::size_t>(position), std::size_t{2});
  return glm::mix(points[below], points[below + 1], position - static_cast<double>(below));
}

}  // namespace

std::vector<Rgb> twin_finish(const std::vector<Rgb>& lit, PictureSize size, const Scene::Finish& finish) {
  std::vector<Rgb> finished = smoothed(lit, size, finish);
  if (finish.colours == ColourMap::kNone) return finished;
  for (Rgb& colour : finished) colour = mapped(finish.colours, luminance(colour));
  return finished;
}

}  // namespace fanlight::test
