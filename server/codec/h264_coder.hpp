// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/codec/picture_coder.hpp"

class ISVCEncoder;

namespace fanlight {

/// Encodes H.264 with openh264: constrained baseline profile, Annex B, one slice a picture, parameter sets
/// with each key picture. Each call returns its own picture: none is delayed. Width and height must be even.
/// A picture of another size begins a new stream with a key picture.
class H264Coder : public PictureCoder {
 public:
  /// `rate_hz`: of the pictures, for the bit rate control; 0: unknown.
  H264Coder(int kbps, double rate_hz) : kbps_(kbps), rate_hz_(rate_hz) {}

  Result<CodedPicture> encode(const Pixels& pixels, bool key) override;

 private:
  /// Makes an encoder for pictures of this size.
  Result<void> begin(const Pixels& pixels);

  struct Release {
    void operator()(ISVCEncoder* encoder) const;
  };
  int kbps_;
  double rate_hz_;
  std::unique_ptr<ISVCEncoder, Release> encoder_;
  std::uint32_t width_ = 0;
  std::uint32_t height_ = 0;
  std::vector<std::uint8_t> planes_;  // I420
  std::vector<std::uint8_t> bytes_;
};

}  // namespace fanlight
