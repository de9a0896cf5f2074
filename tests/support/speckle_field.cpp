// SPDX-License-Identifier: Apache-2.0
#include "tests/support/speckle_field.hpp"

#include <cmath>
#include <numeric>
#include <span>

#include "acquisition/phantom/speckle_tile.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight::test {

namespace {

using Values = std::vector<float>;

/// Complex amplitude of the echo of many scatterers in each pixel.
struct Field {
  Values real;
  Values imaginary;
};

Field scatterers(std::size_t voxels, std::uint64_t seed) {
  Field field{Values(voxels), Values(voxels)};
  const std::uint64_t origin = mixed_bits(seed + 1);
  // Box-Muller method, because std::normal_distribution differs between standard libraries.
  for (std::size_t i = 0; i < voxels; ++i) {
    constexpr double kUnit = 0x1p-32;
    const std::uint64_t bits = mixed_bits(origin + i * 0x9E37'79B9'7F4A'7C15U);
    const double radius = std::sqrt(-2 * std::log((static_cast<double>(bits >> 32) + 0.5) * kUnit));
    const double angle = 2 * kPi * static_cast<double>(bits & 0xFFFF'FFFFU) * kUnit;
    field.real[i] = static_cast<float>(radius * std::cos(angle));
    field.imaginary[i] = static_cast<float>(radius * std::sin(angle));
  }
  return field;
}

/// Gaussian kernel that gives grains of `full_width`. The autocovariance of the amplitude is about the square
/// of the autocorrelation of the field. After smoothing with a Gaussian of standard deviation s it is
/// exp(-d^2 / (2 s^2)), which has the width of the kernel itself.
Values kernel_of(double full_width) {
  const double deviation = full_width / (2 * std::sqrt(2 * std::log(2.0)));
  const int reach = static_cast<int>(std::ceil(3.5 * deviation));
  Values kernel;
  for (int i = -reach; i <= reach; ++i) {
    kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (deviation * deviation))));
  }
  return kernel;
}

/// Circular convolution along the middle axis of an array (outer, length, inner).
void smooth(Values& values, std::size_t length, std::size_t inner, const Values& kernel) {
  const std::size_t reach = kernel.size() / 2;
  const std::size_t block = length * inner;
  Values smoothed(values.size(), 0.0F);
  for (std::size_t outer = 0; outer < values.size(); outer += block) {
    for (std::size_t index = 0; index < length; ++index) {
      float* const to = &smoothed[outer + index * inner];
      for (std::size_t tap = 0; tap < kernel.size(); ++tap) {
        const float* const from = &values[outer + (index + length + tap - reach) % length * inner];
        for (std::size_t i = 0; i < inner; ++i) to[i] += kernel[tap] * from[i];
      }
    }
  }
  values = std::move(smoothed);
}

void smooth(Values& values, const SpeckleField::Size& size, const SpeckleField::Grain& grain) {
  const std::size_t frame = std::size_t{size.rows} * size.columns;
  smooth(values, size.columns, 1, kernel_of(grain.columns));
  smooth(values, size.rows, size.columns, kernel_of(grain.rows));
  smooth(values, size.frames, frame, kernel_of(grain.frames));
}

}  // namespace

SpeckleField::SpeckleField(const Size& size, const Grain& grain, std::uint64_t seed) : size_(size) {
  Field field = scatterers(std::size_t{size.columns} * size.rows * size.frames, seed);
  smooth(field.real, size, grain);
  smooth(field.imaginary, size, grain);
  factors_ = std::move(field.real);
  double sum = 0;
  for (std::size_t i = 0; i < factors_.size(); ++i) {
    factors_[i] = std::hypot(factors_[i], field.imaginary[i]);
    sum += factors_[i];
  }
  const auto scale = static_cast<float>(static_cast<double>(factors_.size()) / sum);
  for (float& factor : factors_) factor *= scale;
}

}  // namespace fanlight::test
