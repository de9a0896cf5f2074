// SPDX-License-Identifier: Apache-2.0
#include "server/codec/h264_coder.hpp"

#include <fmt/format.h>
#include <libyuv/convert.h>
#include <wels/codec_api.h>

#include <cstring>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

constexpr float kDefaultHz = 15;

Error failed(const char* what, int code) {
  return {ErrorCode::kUnavailable, fmt::format("openh264 could not {} (code {})", what, code)};
}

}  // namespace

void H264Coder::Release::operator()(ISVCEncoder* encoder) const {
  encoder->Uninitialize();
  WelsDestroySVCEncoder(encoder);
}

Result<void> H264Coder::begin(const Pixels& pixels) {
  encoder_.reset();
  ISVCEncoder* encoder = nullptr;
  if (const int code = WelsCreateSVCEncoder(&encoder); code != 0 || encoder == nullptr)
    return failed("be made", code);
  encoder_.reset(encoder);
  int quiet = WELS_LOG_QUIET;
  encoder->SetOption(ENCODER_OPTION_TRACE_LEVEL, &quiet);
  SEncParamExt parameters;
  encoder->GetDefaultParams(&parameters);
  const float rate_hz = rate_hz_ > 0 ? static_cast<float>(rate_hz_) : kDefaultHz;
  parameters.iUsageType = CAMERA_VIDEO_REAL_TIME;
  parameters.iPicWidth = static_cast<int>(pixels.width);
  parameters.iPicHeight = static_cast<int>(pixels.height);
  parameters.iTargetBitrate = kbps_ * 1000;
  parameters.iRCMode = RC_BITRATE_MODE;
  parameters.fMaxFrameRate = rate_hz;
  parameters.bEnableFrameSkip = false;  // a client could not detect the missing picture
  parameters.uiIntraPeriod = 0;         // key pictures on request only
  parameters.eSpsPpsIdStrategy = CONSTANT_ID;
  parameters.iMultipleThreadIdc = 1;
  parameters.iSpatialLayerNum = 1;
  SSpatialLayerConfig& layer = parameters.sSpatialLayers[0];
  layer.uiProfileIdc = PRO_BASELINE;
  layer.iVideoWidth = parameters.iPicWidth;
  layer.iVideoHeight = parameters.iPicHeight;
  layer.fFrameRate = rate_hz;
  layer.iSpatialBitrate = parameters.iTargetBitrate;
  layer.sSliceArgument.uiSliceMode = SM_SINGLE_SLICE;
  if (const int code = encoder->InitializeExt(&parameters); code != 0) {
    encoder_.reset();
    return failed(fmt::format("encode pictures of {} x {}", pixels.width, pixels.height).c_str(), code);
  }
  width_ = pixels.width;
  height_ = pixels.height;
  planes_.resize(std::size_t{3} * width_ * height_ / 2);
  return {};
}

Result<CodedPicture> H264Coder::encode(const Pixels& pixels, bool key) {
  if (encoder_ == nullptr || width_ != pixels.width || height_ != pixels.height) {
    if (auto begun = begin(pixels); !begun) return begun.error();
    key = true;
  }
  const int width = static_cast<int>(width_);
  const int height = static_cast<int>(height_);
  std::uint8_t* const luma = planes_.data();
  std::uint8_t* const blue = luma + std::size_t{width_} * height_;
  std::uint8_t* const red = blue + std::size_t{width_} * height_ / 4;
  // libyuv names the bytes of a little-endian word from the highest: ABGR is R, G, B, A in memory.
  libyuv::ABGRToI420(pixels.rgba.data(), 4 * width, luma, width, blue, width / 2, red, width / 2, width,
                     height);
  SSourcePicture source;
  std::memset(&source, 0, sizeof source);
  source.iPicWidth = width;
  source.iPicHeight = height;
  source.iColorFormat = videoFormatI420;
  source.iStride[0] = width;
  source.iStride[1] = source.iStride[2] = width / 2;
  source.pData[0] = luma;
  source.pData[1] = blue;
  source.pData[2] = red;
  source.uiTimeStamp = now_ns() / 1'000'000;
  if (key) encoder_->ForceIntraFrame(true);
  SFrameBSInfo info;
  std::memset(&info, 0, sizeof info);
  if (const int code = encoder_->EncodeFrame(&source, &info); code != cmResultSuccess) {
    return failed("encode a picture", code);
  }
  bytes_.clear();
  for (int index = 0; index < info.iLayerNum; ++index) {
    const SLayerBSInfo& layer = info.sLayerInfo[index];
    std::size_t bytes = 0;
    for (int unit = 0; unit < layer.iNalCount; ++unit)
      bytes += static_cast<std::size_t>(layer.pNalLengthInByte[unit]);
    bytes_.insert(bytes_.end(), layer.pBsBuf, layer.pBsBuf + bytes);
  }
  if (bytes_.empty()) return failed("encode a picture", static_cast<int>(info.eFrameType));
  return CodedPicture{.bytes = bytes_, .key = info.eFrameType == videoFrameTypeIDR};
}

}  // namespace fanlight
