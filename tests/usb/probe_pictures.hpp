#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "acquisition/phantom_source.hpp"
#include "proto/result.hpp"

namespace fanlight::test {

/// What the emulated probe sees: the pictures of sweeps to and fro over the scene of PhantomSource, under one
/// sweep angle and one number of frames a sweep. Pictures are counted from 0; even sweeps go forward. One
/// thread.
class ProbePictures {
 public:
  struct Config {
    double frame_rate_hz = 20;  ///< of the scene's time; above 1000 it is taken as 1000
    std::uint32_t frames_per_volume = 35;
    std::uint32_t columns = 512;
    std::uint32_t rows = 512;  ///< over 160 mm
    double sweep_deg = 70;
    std::uint64_t seed = 1;
    /// Pictures are drawn once for a sweep forth and one back and then shown again and again: as fast as the
    /// host takes them, where drawing one takes some milliseconds.
    bool prepared = false;
  };

  /// kInvalidArgument where a value is out of PhantomSource's range.
  static Result<std::unique_ptr<ProbePictures>> create(const Config& config);

  const FanGeometry& geometry() const { return source_->description().geometry; }

  struct Place {
    std::uint64_t sweep = 0;
    std::uint32_t index = 0;  ///< in the sweep, in the order taken
    SweepDirection direction = SweepDirection::kForward;
    double angle_deg = 0;
  };
  Place place(std::uint64_t picture) const;

  struct Picture {
    std::span<const std::uint8_t> pixels;  ///< valid until the next call
    std::uint32_t crc32c = 0;
  };
  /// The first `rows` rows of a picture. `picture` must grow from call to call, as time does; a prepared one
  /// shows the scene as it was when its place in the two sweeps was first asked for.
  Picture show(std::uint64_t picture, std::uint32_t rows);

  /// Draws all that a prepared one will ever show with that many rows; otherwise does nothing.
  void prepare(std::uint32_t rows);

 private:
  struct Kept {
    std::vector<std::uint8_t> pixels;
    std::uint32_t rows = 0;  ///< that the checksum is of
    std::uint32_t crc32c = 0;
  };

  ProbePictures(const Config& config, std::unique_ptr<PhantomSource> source);

  void draw(std::uint64_t picture, std::vector<std::uint8_t>& pixels);

  Config config_;
  std::unique_ptr<PhantomSource> source_;
  std::vector<Kept> kept_;  // prepared: of two sweeps; otherwise one
};

}  // namespace fanlight::test
