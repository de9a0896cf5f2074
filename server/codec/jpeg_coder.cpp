// SPDX-License-Identifier: Apache-2.0
#include "server/codec/jpeg_coder.hpp"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>

namespace fanlight {

namespace {

constexpr int kFirstQuality = 75;
constexpr int kLeastQuality = 10;
constexpr int kBestQuality = 95;
// Between quality 30 and 90, 15 steps of quality about double the bytes.
constexpr double kStepsPerOctave = 15;

}  // namespace

void JpegCoder::Release::operator()(void* handle) const {
  tjDestroy(handle);
}

JpegCoder::JpegCoder(int quality, int kbps, Clock clock)
    : handle_(tjInitCompress()), quality_(quality), kbps_(kbps), clock_(std::move(clock)) {}

std::unique_ptr<JpegCoder> JpegCoder::with_bit_rate(int kbps, Clock clock) {
  return std::unique_ptr<JpegCoder>(new JpegCoder(kFirstQuality, kbps, std::move(clock)));
}

Result<CodedPicture> JpegCoder::encode(const Pixels& pixels, bool /*key*/) {
  if (handle_ == nullptr)
    return Error{ErrorCode::kUnavailable, "the JPEG encoder could not be made, expected memory for it"};
  const int width = static_cast<int>(pixels.width);
  const int height = static_cast<int>(pixels.height);
  jpeg_.resize(tjBufSize(width, height, TJSAMP_444));
  unsigned char* target = jpeg_.data();
  unsigned long bytes = jpeg_.size();
  const int failed = tjCompress2(handle_.get(), pixels.rgba.data(), width, 0, height, TJPF_RGBX, &target,
                                 &bytes, TJSAMP_444, quality_, TJFLAG_NOREALLOC);
  if (failed != 0) {
    return Error{ErrorCode::kBroken, fmt::format("encoding a picture of {} x {} failed: {}", width, height,
                                                 tjGetErrorStr2(handle_.get()))};
  }
  if (kbps_ > 0) adapt_quality(bytes);
  return CodedPicture{.bytes = {jpeg_.data(), bytes}};
}

void JpegCoder::adapt_quality(std::size_t bytes) {
  constexpr double kPauseS = 10;
  const std::int64_t now = clock_();
  const double since_s = static_cast<double>(now - std::exchange(last_ns_, now)) / 1e9;
  if (since_s > kPauseS) return;  // the first picture, or the first after a pause
  interval_s_ = interval_s_ == 0 ? since_s : 0.8 * interval_s_ + 0.2 * since_s;
  const double wanted_bytes = kbps_ * 1000.0 / 8 * interval_s_;
  const double octaves = std::log2(static_cast<double>(bytes) / std::max(wanted_bytes, 1.0));
  const int step = static_cast<int>(std::lround(0.5 * kStepsPerOctave * octaves));
  quality_ = std::clamp(quality_ - step, kLeastQuality, kBestQuality);
}

}  // namespace fanlight
