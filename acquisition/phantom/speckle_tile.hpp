// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fanlight {

/// Seamless square of fully developed speckle: Rayleigh distributed factors of mean 1, correlated over about
/// 2 pixels down (axial) and 3 across (lateral), as behind a real beam. Fixed point: `kOne` is 1; factors are
/// limited just below 4. Equal seeds give equal tiles.
class SpeckleTile {
 public:
  static constexpr std::uint32_t kSide = 512;  ///< a power of two: coordinates wrap by masking
  static constexpr std::uint32_t kOne = 64;

  /// No speckle: every factor is kOne.
  SpeckleTile() : factors_(std::size_t{kSide} * kSide, kOne) {}
  explicit SpeckleTile(std::uint64_t seed);

  /// The kSide factors of a row; the row index wraps.
  const std::uint8_t* row(std::uint32_t row) const { return factors_.data() + (row % kSide) * kSide; }

 private:
  std::vector<std::uint8_t> factors_;
};

/// One step of the SplitMix64 generator: a well mixed number for each state. The caller advances the state by
/// an odd constant.
std::uint64_t mixed_bits(std::uint64_t state);

}  // namespace fanlight
