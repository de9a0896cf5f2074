// SPDX-License-Identifier: Apache-2.0
#include "server/codec/picture_coder.hpp"

#include <libyuv/scale_argb.h>

#include <algorithm>
#include <cmath>

#include "server/codec/h264_coder.hpp"
#include "server/codec/jpeg_coder.hpp"
#include "server/codec/png_coder.hpp"

namespace fanlight {

Result<std::unique_ptr<PictureCoder>> make_coder(const StreamSettings& settings) {
  using Coder = std::unique_ptr<PictureCoder>;
  switch (settings.codec) {
    case StreamSettings::Codec::kPng:
      return Coder(std::make_unique<PngCoder>());
    case StreamSettings::Codec::kH264:
      return Coder(std::make_unique<H264Coder>(settings.bit_rate_kbps, settings.rate_hz));
    case StreamSettings::Codec::kJpeg:
    case StreamSettings::Codec::kSurface:  // what a picture shows beside its surface
      break;
  }
  if (settings.bit_rate_kbps > 0) return Coder(JpegCoder::with_bit_rate(settings.bit_rate_kbps));
  return Coder(std::make_unique<JpegCoder>(settings.quality));
}

Pixels PictureScaler::fitted(const Pixels& pixels, const StreamSettings& settings) {
  const double across = settings.most_width > 0 ? static_cast<double>(settings.most_width) / pixels.width : 1;
  const double down =
      settings.most_height > 0 ? static_cast<double>(settings.most_height) / pixels.height : 1;
  const double scale = std::min({across, down, 1.0});
  const bool even = settings.codec == StreamSettings::Codec::kH264;
  const auto side = [&](std::uint32_t full) {
    const auto scaled = static_cast<std::uint32_t>(std::lround(full * scale));
    return std::max(even ? scaled & ~1U : scaled, even ? 16U : 1U);
  };
  const std::uint32_t width = side(pixels.width);
  const std::uint32_t height = side(pixels.height);
  if (width == pixels.width && height == pixels.height) return pixels;
  scaled_.resize(std::size_t{4} * width * height);
  libyuv::ARGBScale(pixels.rgba.data(), static_cast<int>(4 * pixels.width), static_cast<int>(pixels.width),
                    static_cast<int>(pixels.height), scaled_.data(), static_cast<int>(4 * width),
                    static_cast<int>(width), static_cast<int>(height), libyuv::kFilterBox);
  return {.width = width, .height = height, .rgba = scaled_};
}

}  // namespace fanlight
