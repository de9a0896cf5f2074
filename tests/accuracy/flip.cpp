// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/flip.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <numbers>

namespace fanlight::test {

namespace {

using glm::dmat3;
using glm::dvec3;
using std::numbers::pi;

double squared(double value) {
  return value * value;
}

// Linear sRGB to XYZ, D65 (IEC 61966-2-1). Columns.
constexpr dmat3 kToXyz(0.4124564, 0.2126729, 0.0193339,  // red
                       0.3575761, 0.7151522, 0.1191920,  // green
                       0.1804375, 0.0721750, 0.9503041);

dvec3 linear(const dvec3& colour) {
  const auto channel = [](double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  return {channel(colour.r), channel(colour.g), channel(colour.b)};
}

/// Relative to white.
dvec3 relative_xyz(const dvec3& linear_rgb) {
  return (kToXyz * linear_rgb) / (kToXyz * dvec3(1));
}

/// Luminance and two opponent colours, linear in XYZ.
dvec3 opponents(const dvec3& linear_rgb) {
  const dvec3 xyz = relative_xyz(linear_rgb);
  return {116 * xyz.y - 16, 500 * (xyz.x - xyz.y), 200 * (xyz.y - xyz.z)};
}

dvec3 from_opponents(const dvec3& colour) {
  const double y = (colour.x + 16) / 116;
  const dvec3 xyz(y + colour.y / 500, y, y - colour.z / 200);
  return glm::inverse(kToXyz) * (xyz * (kToXyz * dvec3(1)));
}

/// CIE L*a*b*, whose colours fade in the dark (Hunt).
dvec3 hunt_lab(const dvec3& linear_rgb) {
  const dvec3 xyz = relative_xyz(linear_rgb);
  const auto root = [](double value) {
    constexpr double kEdge = 6.0 / 29;
    return value > kEdge * kEdge * kEdge ? std::cbrt(value) : value / (3 * kEdge * kEdge) + 4.0 / 29;
  };
  const double lightness = 116 * root(xyz.y) - 16;
  const double fade = 0.01 * lightness;
  return {lightness, fade * 500 * (root(xyz.x) - root(xyz.y)), fade * 200 * (root(xyz.y) - root(xyz.z))};
}

double hyab(const dvec3& a, const dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

/// Weights over a square of pixels, 2 radius + 1 a side.
struct Kernel {
  int radius = 0;
  std::vector<double> weights;

  /// `value` of the distances in pixels to the right and down.
  static Kernel of(int radius, const std::function<double(int, int)>& value) {
    Kernel made{radius, {}};
    for (int down = -radius; down <= radius; ++down) {
      for (int right = -radius; right <= radius; ++right) made.weights.push_back(value(right, down));
    }
    return made;
  }

  /// Scales the positive weights to a sum of 1, and the negative ones to -1.
  void normalize() {
    double positive = 0;
    double negative = 0;
    for (const double weight : weights) (weight > 0 ? positive : negative) += weight;
    for (double& weight : weights) weight /= weight > 0 ? positive : -std::min(negative, -1e-300);
  }
};

/// Beyond the border the border's pixels are repeated.
template <typename Value>
Value filtered(std::span<const Value> values, PictureSize size, const Kernel& kernel, int column, int row) {
  const int last_column = static_cast<int>(size.width) - 1;
  const int last_row = static_cast<int>(size.height) - 1;
  Value sum(0);
  auto weight = kernel.weights.begin();
  for (int down = -kernel.radius; down <= kernel.radius; ++down) {
    const auto line = static_cast<std::size_t>(std::clamp(row + down, 0, last_row)) * size.width;
    for (int right = -kernel.radius; right <= kernel.radius; ++right) {
      sum += *weight++ * values[line + static_cast<std::size_t>(std::clamp(column + right, 0, last_column))];
    }
  }
  return sum;
}

template <typename Visit>
void for_each_pixel(PictureSize size, Visit visit) {
  for (int row = 0; row < static_cast<int>(size.height); ++row) {
    for (int column = 0; column < static_cast<int>(size.width); ++column) visit(column, row);
  }
}

/// What an observer sees of the contrast: the sensitivity for luminance, red-green and blue-yellow, each a
/// sum of Gaussians over degrees.
class ContrastFilter {
 public:
  explicit ContrastFilter(double pixels_per_degree) {
    struct Sum {
      double a1, b1, a2, b2;
    };
    constexpr Sum kSums[] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * pixels_per_degree));
    for (std::size_t channel = 0; channel < std::size(kSums); ++channel) {
      const Sum& sum = kSums[channel];
      kernels_[channel] = Kernel::of(radius, [&](int right, int down) {
        const double degrees_squared = (squared(right) + squared(down)) / squared(pixels_per_degree);
        return sum.a1 * std::sqrt(pi / sum.b1) * std::exp(-pi * pi * degrees_squared / sum.b1) +
               sum.a2 * std::sqrt(pi / sum.b2) * std::exp(-pi * pi * degrees_squared / sum.b2);
      });
      kernels_[channel].normalize();
    }
  }

  std::vector<dvec3> seen_lab(std::span<const dvec3> picture, PictureSize size) const {
    std::array<std::vector<double>, 3> channels;
    for (const dvec3& colour : picture) {
      const dvec3 opponent = opponents(linear(colour));
      for (int channel = 0; channel < 3; ++channel) channels[channel].push_back(opponent[channel]);
    }
    std::vector<dvec3> seen;
    for_each_pixel(size, [&](int column, int row) {
      dvec3 colour;
      for (int channel = 0; channel < 3; ++channel)
        colour[channel] = filtered<double>(channels[channel], size, kernels_[channel], column, row);
      seen.push_back(hunt_lab(glm::clamp(from_opponents(colour), 0.0, 1.0)));
    });
    return seen;
  }

 private:
  std::array<Kernel, 3> kernels_;
};

/// Strength of edges and of points at each pixel.
struct Features {
  std::vector<double> edges;
  std::vector<double> points;
};

Features features_of(std::span<const dvec3> picture, PictureSize size, double pixels_per_degree) {
  constexpr double kWidthDegrees = 0.082;
  const double deviation = 0.5 * kWidthDegrees * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  const auto gauss = [&](int right, int down) {
    return std::exp(-(squared(right) + squared(down)) / (2 * squared(deviation)));
  };
  const auto normalized = [&](const std::function<double(int, int)>& value) {
    Kernel kernel = Kernel::of(radius, value);
    kernel.normalize();
    return kernel;
  };
  const auto first = [&](int along, int across) { return -along * gauss(along, across); };
  const auto second = [&](int along, int across) {
    return (squared(along) / squared(deviation) - 1) * gauss(along, across);
  };
  const auto turned = [](const auto& value) {
    return [value](int right, int down) { return value(down, right); };
  };
  const Kernel edge_x = normalized(first);
  const Kernel edge_y = normalized(turned(first));
  const Kernel point_x = normalized(second);
  const Kernel point_y = normalized(turned(second));
  std::vector<double> luminance;
  for (const dvec3& colour : picture) luminance.push_back(relative_xyz(linear(colour)).y);
  Features features;
  for_each_pixel(size, [&](int column, int row) {
    const auto value = [&](const Kernel& kernel) {
      return filtered<double>(luminance, size, kernel, column, row);
    };
    features.edges.push_back(std::hypot(value(edge_x), value(edge_y)));
    features.points.push_back(std::hypot(value(point_x), value(point_y)));
  });
  return features;
}

/// The difference of colours, 0 to 1.
double colour_error(const dvec3& a, const dvec3& b) {
  constexpr double kPower = 0.7;
  constexpr double kShare = 0.4;
  constexpr double kKnee = 0.95;
  static const double most = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kPower);
  const double apart = std::pow(hyab(a, b), kPower);
  const double knee = kShare * most;
  return apart < knee ? kKnee / knee * apart : kKnee + (apart - knee) / (most - knee) * (1 - kKnee);
}

}  // namespace

std::vector<double> flip_errors(std::span<const dvec3> reference, std::span<const dvec3> shown,
                                PictureSize size, double pixels_per_degree) {
  const ContrastFilter contrast(pixels_per_degree);
  const std::vector<dvec3> reference_lab = contrast.seen_lab(reference, size);
  const std::vector<dvec3> shown_lab = contrast.seen_lab(shown, size);
  const Features in_reference = features_of(reference, size, pixels_per_degree);
  const Features in_shown = features_of(shown, size, pixels_per_degree);
  std::vector<double> errors;
  for (std::size_t pixel = 0; pixel < reference.size(); ++pixel) {
    const double edge = std::abs(in_reference.edges[pixel] - in_shown.edges[pixel]);
    const double point = std::abs(in_reference.points[pixel] - in_shown.points[pixel]);
    const double feature = std::sqrt(std::max(edge, point) / std::numbers::sqrt2);
    errors.push_back(std::pow(colour_error(reference_lab[pixel], shown_lab[pixel]), 1 - feature));
  }
  return errors;
}

}  // namespace fanlight::test
