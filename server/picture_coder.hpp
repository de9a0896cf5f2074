#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/result.hpp"
#include "server/stream_settings.hpp"

namespace fanlight {

/// A picture to be encoded: height x width x 4 bytes, RGBA, top row first.
struct Pixels {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::span<const std::uint8_t> rgba;
};

inline Pixels pixels_of(const Picture& picture) {
  return {.width = picture.width, .height = picture.height, .rgba = picture.rgba};
}

/// What an encoder made of a picture; valid until its next call.
struct CodedPicture {
  std::span<const std::uint8_t> bytes;
  bool key = true;  ///< it can be shown without those before it
};

/// Pictures of one stream, one after the other, to bytes. One thread.
class PictureCoder {
 public:
  virtual ~PictureCoder() = default;

  /// `key`: it must do without those before it. Error: the library's.
  virtual Result<CodedPicture> encode(const Pixels& pixels, bool key) = 0;
};

/// The coder that a stream needs. Errors: a library that cannot be set up.
Result<std::unique_ptr<PictureCoder>> make_coder(const StreamSettings& settings);

/// Makes pictures smaller, each pixel the mean of those it covers (libyuv), and keeps the last one.
class PictureScaler {
 public:
  /// As large as fits into the most that is asked for, in its own proportions; even sides for H.264. Larger
  /// than it is it does not become.
  Pixels fitted(const Pixels& pixels, const StreamSettings& settings);

 private:
  std::vector<std::uint8_t> scaled_;
};

}  // namespace fanlight
