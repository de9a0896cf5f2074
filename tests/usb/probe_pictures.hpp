// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "acquisition/phantom/phantom_source.hpp"
#include "proto/base/result.hpp"

namespace fanlight::test {

/// Pictures of the emulated probe: forward and backward sweeps over the scene of PhantomSource, with one
/// sweep angle and number of frames. Pictures are counted from 0; even sweeps are forward. One thread.
class ProbePictures {
 public:
  struct Config {
    double frame_rate_hz = 20;  ///< of the scene's time; limited to 1000
    std::uint32_t frames_per_volume = 35;
    std::uint32_t columns = 512;
    std::uint32_t rows = 512;  ///< over 160 mm
    double sweep_deg = 70;
    std::uint64_t seed = 1;
    /// Pictures of one forward and one backward sweep are drawn once and then repeated. They are available at
    /// any rate, while drawing one takes some milliseconds.
    bool prepared = false;
  };

  /// kInvalidArgument where a value is out of PhantomSource's range.
  static Result<std::unique_ptr<ProbePictures>> create(const Config& config);

  const FanGeometry& geometry() const { return source_->description().geometry; }

  struct Place {
    std::uint64_t sweep = 0;
    std::uint32_t index = 0;  ///< in the sweep, in the order of capture
    SweepDirection direction = SweepDirection::kForward;
    double angle_deg = 0;
  };
  Place place(std::uint64_t picture) const;

  struct Picture {
    std::span<const std::uint8_t> pixels;  ///< valid until the next call
    std::uint32_t crc32c = 0;
  };
  /// The first `rows` rows of a picture. `picture` must increase from call to call. A prepared picture shows
  /// the scene at the time of its first request.
  Picture show(std::uint64_t picture, std::uint32_t rows);

  /// Draws all prepared pictures with that many rows; otherwise does nothing.
  void prepare(std::uint32_t rows);

 private:
  struct Kept {
    std::vector<std::uint8_t> pixels;
    std::uint32_t rows = 0;  ///< covered by the checksum
    std::uint32_t crc32c = 0;
  };

  ProbePictures(const Config& config, std::unique_ptr<PhantomSource> source);

  void draw(std::uint64_t picture, std::vector<std::uint8_t>& pixels);

  Config config_;
  std::unique_ptr<PhantomSource> source_;
  std::vector<Kept> kept_;  // prepared: of two sweeps; otherwise one
};

}  // namespace fanlight::test
