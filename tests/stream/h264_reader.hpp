// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <wels/codec_api.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fanlight::test {

using Bytes = std::vector<std::uint8_t>;

/// Decodes H.264 with openh264 and returns the luma.
class H264Reader {
 public:
  H264Reader() {
    WelsCreateDecoder(&decoder_);
    SDecodingParam parameters{};
    parameters.sVideoProperty.eVideoBsType = VIDEO_BITSTREAM_AVC;
    decoder_->Initialize(&parameters);
  }
  ~H264Reader() {
    decoder_->Uninitialize();
    WelsDestroyDecoder(decoder_);
  }
  H264Reader(const H264Reader&) = delete;
  H264Reader& operator=(const H264Reader&) = delete;

  /// Luma, row by row; empty if the bytes give no picture.
  Bytes luma(std::span<const std::uint8_t> bytes) {
    std::uint8_t* planes[3] = {};
    SBufferInfo info{};
    if (decoder_->DecodeFrameNoDelay(bytes.data(), static_cast<int>(bytes.size()), planes, &info) !=
        dsErrorFree)
      return {};
    if (info.iBufferStatus != 1) return {};
    Bytes picture;
    const auto& format = info.UsrData.sSystemBuffer;
    for (int row = 0; row < format.iHeight; ++row) {
      const std::uint8_t* const from = planes[0] + static_cast<std::ptrdiff_t>(row) * format.iStride[0];
      picture.insert(picture.end(), from, from + format.iWidth);
    }
    return picture;
  }

 private:
  ISVCDecoder* decoder_ = nullptr;
};

}  // namespace fanlight::test
