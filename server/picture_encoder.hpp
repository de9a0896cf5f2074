#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "proto/picture.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// Pictures to JPEG, through libjpeg-turbo. One thread.
class PictureEncoder {
 public:
  /// Quality 1 to 100. Colour is kept at full resolution: the edges of a lit surface are in its colour.
  explicit PictureEncoder(int quality);

  /// The JPEG of the picture; valid until the next call.
  Result<std::span<const std::uint8_t>> encode(const Picture& picture);

 private:
  struct Release {
    void operator()(void* handle) const;
  };
  std::unique_ptr<void, Release> handle_;
  int quality_;
  std::vector<std::uint8_t> jpeg_;
};

}  // namespace fanlight
