// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fanlight::test {

/// Fully developed speckle of a whole sweep, as of a real beam: the magnitude of a complex Gaussian field
/// that is smoothed along the lines, across them and from frame to frame, by the same number of frames at
/// each depth. The factors are Rayleigh distributed with mean 1 (standard deviation 0.52). The field is
/// periodic in each direction. Equal seeds give equal fields on every machine.
class SpeckleField {
 public:
  struct Size {
    std::uint32_t columns = 0;
    std::uint32_t rows = 0;
    std::uint32_t frames = 0;
  };
  /// Size of a grain: full width at half maximum of the autocovariance of the factors, in pixels and frames.
  struct Grain {
    double columns = 0;
    double rows = 0;
    double frames = 0;
  };

  SpeckleField(const Size& size, const Grain& grain, std::uint64_t seed);

  /// Factors of a frame, rows x columns. Frames are indexed in order of angle.
  const float* frame(std::uint32_t frame) const {
    return factors_.data() + std::size_t{frame} * size_.rows * size_.columns;
  }

 private:
  Size size_;
  std::vector<float> factors_;
};

}  // namespace fanlight::test
