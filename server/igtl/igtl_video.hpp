// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/igtl/image_body.hpp"
#include "proto/model/picture.hpp"
#include "server/codec/picture_coder.hpp"

namespace fanlight {

/// The content of a VIDEO message.
struct IgtlVideoContent {
  std::vector<std::uint8_t> bytes;
  bool key = false;  ///< can be decoded without the pictures before it
};

/// Encodes the pictures of the main view as H.264, once for all OpenIGTLink clients. One thread at a time.
class IgtlVideo {
 public:
  /// `key`: make a key picture. A picture with an odd side is reduced by a pixel, and its pose accordingly.
  /// Errors: those of the encoder; the next picture must be a key picture then. bad_alloc passes.
  Result<IgtlVideoContent> write(const Picture& picture, bool key);

 private:
  std::unique_ptr<PictureCoder> coder_;
  PictureScaler scaler_;
};

/// The pose of a picture that was scaled from one size to another one and covers the same rectangle.
igtl::GridPose scaled_pose(const igtl::GridPose& pose, const Pixels& from, const Pixels& to);

}  // namespace fanlight
