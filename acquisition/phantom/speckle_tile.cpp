// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/speckle_tile.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kSide = SpeckleTile::kSide;
constexpr std::size_t kPixels = kSide * kSide;

// Standard deviations of the beam's point spread, pixels; the full width of the echo at half maximum is 2.35
// times that.
constexpr float kAxialSpread = 0.85F;
constexpr float kLateralSpread = 1.3F;
constexpr int kKernelReach = 4;

using Kernel = std::array<float, 2 * kKernelReach + 1>;

Kernel gaussian(float spread) {
  Kernel kernel{};
  for (int i = -kKernelReach; i <= kKernelReach; ++i) {
    const float at = static_cast<float>(i) / spread;
    kernel[i + kKernelReach] = std::exp(-0.5F * at * at);
  }
  return kernel;
}

/// Real and imaginary part of the echo of many scatterers in each pixel.
struct Field {
  std::vector<float> real = std::vector<float>(kPixels);
  std::vector<float> imaginary = std::vector<float>(kPixels);
};

Field scatterers(std::uint64_t seed) {
  Field field;
  // Box-Muller method: the normal distribution of the standard library differs between implementations.
  for (std::size_t i = 0; i < kPixels; ++i) {
    constexpr double kUnit = 0x1p-32;
    const std::uint64_t bits = mixed_bits(seed + i * 0x9E37'79B9'7F4A'7C15U);
    const double radius = std::sqrt(-2 * std::log((static_cast<double>(bits >> 32) + 0.5) * kUnit));
    const double angle = 2 * kPi * static_cast<double>(bits & 0xFFFF'FFFFU) * kUnit;
    field.real[i] = static_cast<float>(radius * std::cos(angle));
    field.imaginary[i] = static_cast<float>(radius * std::sin(angle));
  }
  return field;
}

/// Convolution with the beam. It wraps around the edges, so that the tile has no seam.
void blur(std::vector<float>& values, const Kernel& axial, const Kernel& lateral) {
  std::vector<float> across(kPixels);
  for (std::size_t row = 0; row < kSide; ++row) {
    const float* from = &values[row * kSide];
    float* to = &across[row * kSide];
    for (std::size_t column = 0; column < kSide; ++column) {
      float sum = 0;
      for (int i = -kKernelReach; i <= kKernelReach; ++i) {
        sum += lateral[i + kKernelReach] * from[(column + kSide + i) % kSide];
      }
      to[column] = sum;
    }
  }
  for (std::size_t row = 0; row < kSide; ++row) {
    float* to = &values[row * kSide];
    std::fill_n(to, kSide, 0.0F);
    for (int i = -kKernelReach; i <= kKernelReach; ++i) {
      const float* from = &across[((row + kSide + i) % kSide) * kSide];
      for (std::size_t column = 0; column < kSide; ++column)
        to[column] += axial[i + kKernelReach] * from[column];
    }
  }
}

}  // namespace

std::uint64_t mixed_bits(std::uint64_t state) {
  state = (state ^ (state >> 30)) * 0xBF58'476D'1CE4'E5B9U;
  state = (state ^ (state >> 27)) * 0x94D0'49BB'1331'11EBU;
  return state ^ (state >> 31);
}

SpeckleTile::SpeckleTile(std::uint64_t seed) : real_(kPixels), imaginary_(kPixels) {
  Field field = scatterers(mixed_bits(seed + 1));
  const Kernel axial = gaussian(kAxialSpread);
  const Kernel lateral = gaussian(kLateralSpread);
  blur(field.real, axial, lateral);
  blur(field.imaginary, axial, lateral);

  double sum = 0;
  for (std::size_t i = 0; i < kPixels; ++i)
    sum += std::sqrt(field.real[i] * field.real[i] + field.imaginary[i] * field.imaginary[i]);
  const auto scale = static_cast<float>(double{kMean} * static_cast<double>(kPixels) / sum);
  const auto scaled = [scale](float value) { return static_cast<std::int16_t>(std::lround(value * scale)); };
  std::ranges::transform(field.real, real_.begin(), scaled);
  std::ranges::transform(field.imaginary, imaginary_.begin(), scaled);
}

}  // namespace fanlight
