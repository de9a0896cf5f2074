#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "server/picture_coder.hpp"

class ISVCEncoder;

namespace fanlight {

/// H.264 through openh264: constrained baseline, Annex B, one slice a picture, parameter sets with each key
/// picture, no picture held back. Sides must be even.
class H264Coder : public PictureCoder {
 public:
  explicit H264Coder(int kbps, double rate_hz) : kbps_(kbps), rate_hz_(rate_hz) {}

  Result<CodedPicture> encode(const Pixels& pixels, bool key) override;

 private:
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
