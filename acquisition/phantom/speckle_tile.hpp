// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fanlight {

/// Seamless square of the echoes of many scatterers: complex numbers with a Gaussian distribution, correlated
/// over about 2 pixels down (axial) and 3 across (lateral), as behind a real beam. Their magnitude is fully
/// developed speckle. Equal seeds give equal tiles.
class SpeckleTile {
 public:
  static constexpr std::uint32_t kSide = 512;  ///< a power of two: coordinates wrap by masking
  /// Mean magnitude.
  static constexpr float kMean = 1024;

  explicit SpeckleTile(std::uint64_t seed);

  /// The kSide real and imaginary parts of a row; the row index wraps.
  const std::int16_t* real(std::uint32_t row) const { return real_.data() + first_of(row); }
  const std::int16_t* imaginary(std::uint32_t row) const { return imaginary_.data() + first_of(row); }

 private:
  static std::size_t first_of(std::uint32_t row) { return std::size_t{row % kSide} * kSide; }

  std::vector<std::int16_t> real_;
  std::vector<std::int16_t> imaginary_;
};

/// One step of the SplitMix64 generator: a well mixed number for each state. The caller advances the state by
/// an odd constant.
std::uint64_t mixed_bits(std::uint64_t state);

}  // namespace fanlight
