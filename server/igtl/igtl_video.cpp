// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_video.hpp"

#include "proto/igtl/video_body.hpp"
#include "server/igtl/picture_messages.hpp"

namespace fanlight {

namespace {

// As displays get it that do not ask for another rate.
constexpr StreamSettings kVideoSettings{.codec = StreamSettings::Codec::kH264, .bit_rate_kbps = 4000};

}  // namespace

igtl::GridPose scaled_pose(const igtl::GridPose& pose, const Pixels& from, const Pixels& to) {
  const double across = static_cast<double>(from.width) / to.width;
  const double down = static_cast<double>(from.height) / to.height;
  igtl::GridPose scaled = pose;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    scaled.i_mm[axis] *= across;
    scaled.j_mm[axis] *= down;
    // The corner of the first pixel stays, so its centre moves.
    scaled.first_mm[axis] += (across - 1) / 2 * pose.i_mm[axis] + (down - 1) / 2 * pose.j_mm[axis];
  }
  return scaled;
}

Result<IgtlVideoContent> IgtlVideo::write(const Picture& picture, bool key) {
  if (coder_ == nullptr) {
    auto made = make_coder(kVideoSettings);
    if (!made) return made.error();
    coder_ = *std::move(made);
  }
  const Pixels whole = pixels_of(picture);
  const Pixels fitted = scaler_.fitted(whole, kVideoSettings);
  const auto coded = coder_->encode(fitted, key);
  if (!coded) {
    coder_.reset();
    return coded.error();
  }
  IgtlVideoContent content{.bytes = {}, .key = coded->key};
  content.bytes.reserve(igtl::kVideoHeaderBytes + coded->bytes.size());
  igtl::put_video_header(
      content.bytes, {static_cast<std::uint16_t>(fitted.width), static_cast<std::uint16_t>(fitted.height), 1},
      scaled_pose(plane_of(picture), whole, fitted),
      coded->key ? igtl::VideoFrame::kKey : igtl::VideoFrame::kPredicted);
  content.bytes.insert(content.bytes.end(), coded->bytes.begin(), coded->bytes.end());
  return content;
}

}  // namespace fanlight
