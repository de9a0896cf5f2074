#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fanlight::test {

/// Fully developed speckle of a whole sweep, as behind a real beam: the magnitude of a complex Gaussian field
/// that was smoothed along the lines, across them and from frame to frame, so that neighbouring frames see
/// nearly the same grains (the tile of the simulated probe makes each frame's anew). Rayleigh distributed
/// factors of mean 1 (deviation 0.52). The field wraps around in each direction. Equal seeds give equal
/// fields on every machine.
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

  /// Factors of a frame, in order of angle: rows x columns.
  const float* frame(std::uint32_t frame) const {
    return factors_.data() + std::size_t{frame} * size_.rows * size_.columns;
  }

 private:
  Size size_;
  std::vector<float> factors_;
};

}  // namespace fanlight::test
