// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/base/result.hpp"
#include "server/codec/stream_settings.hpp"

namespace fanlight {

/// A picture to encode: height x width x 4 bytes, RGBA, top row first.
struct Pixels {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const std::uint8_t> rgba;
};

inline Pixels pixels_of(const Picture& picture) {
  return {.width = picture.width, .height = picture.height, .rgba = picture.rgba};
}

/// An encoded picture; valid until the next call of its coder.
struct CodedPicture {
  std::span<const std::uint8_t> bytes;
  bool key = true;  ///< can be decoded without the pictures before it
};

/// Encodes the pictures of one stream in order. One thread.
class PictureCoder {
 public:
  virtual ~PictureCoder() = default;

  /// `key`: make a key picture, which can be decoded without the pictures before it. Errors: those of the
  /// library.
  virtual Result<CodedPicture> encode(const Pixels& pixels, bool key) = 0;
};

/// Makes the coder for these settings. Errors: a library cannot be initialised.
Result<std::unique_ptr<PictureCoder>> make_coder(const StreamSettings& settings);

/// Reduces pictures with a box filter (libyuv). Keeps the memory of the last result.
class PictureScaler {
 public:
  /// The largest picture that fits into most_width x most_height with the same proportions, never larger than
  /// `pixels`; with even sides for H.264. The result is valid until the next call, or as long as `pixels` if
  /// the size is the same.
  Pixels fitted(const Pixels& pixels, const StreamSettings& settings);

 private:
  std::vector<std::uint8_t> scaled_;
};

}  // namespace fanlight
