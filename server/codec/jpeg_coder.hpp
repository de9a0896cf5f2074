// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "proto/base/clock.hpp"
#include "server/codec/picture_coder.hpp"

namespace fanlight {

/// Encodes JPEG with libjpeg-turbo: with a fixed quality, or with a quality that follows a bit rate.
class JpegCoder : public PictureCoder {
 public:
  /// Quality 1 to 100. Colour keeps the full resolution, because the edges of a lit surface show in colour.
  explicit JpegCoder(int quality) : JpegCoder(quality, 0, now_ns) {}

  /// Adapts the quality to about `kbps` kbit a second at whatever rate the pictures come. The rate is
  /// measured with `clock`, which tests replace.
  static std::unique_ptr<JpegCoder> with_bit_rate(int kbps, Clock clock = now_ns);

  Result<CodedPicture> encode(const Pixels& pixels, bool key) override;

  int quality() const { return quality_; }

 private:
  JpegCoder(int quality, int kbps, Clock clock);
  /// Adapts the quality to the size of the picture that was just encoded.
  void adapt_quality(std::size_t bytes);

  struct Release {
    void operator()(void* handle) const;
  };
  std::unique_ptr<void, Release> handle_;
  int quality_;
  int kbps_;  // 0: the quality is fixed
  Clock clock_;
  std::int64_t last_ns_ = 0;  // when the last picture was encoded
  double interval_s_ = 0;     // mean time between pictures, exponentially smoothed; 0: unknown
  std::vector<std::uint8_t> jpeg_;
};

}  // namespace fanlight
