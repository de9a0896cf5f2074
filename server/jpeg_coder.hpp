#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/picture_coder.hpp"

namespace fanlight {

/// JPEG through libjpeg-turbo, of one quality, or of whatever quality keeps to a bit rate.
class JpegCoder : public PictureCoder {
 public:
  /// Quality 1 to 100. Colour is kept at full resolution: the edges of a lit surface are in its colour.
  explicit JpegCoder(int quality) : JpegCoder(quality, 0) {}

  /// About so many bits a second, whatever the rate of pictures turns out to be.
  static std::unique_ptr<JpegCoder> with_bit_rate(int kbps);

  Result<CodedPicture> encode(const Pixels& pixels, bool key) override;

  int quality() const { return quality_; }

 private:
  JpegCoder(int quality, int kbps);
  void steer(std::size_t bytes);

  struct Release {
    void operator()(void* handle) const;
  };
  std::unique_ptr<void, Release> handle_;
  int quality_;
  int kbps_;
  std::int64_t last_ns_ = 0;  // when the picture before was encoded
  double interval_s_ = 0;     // of pictures, smoothed
  std::vector<std::uint8_t> jpeg_;
};

}  // namespace fanlight
