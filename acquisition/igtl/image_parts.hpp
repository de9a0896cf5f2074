// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "proto/igtl/image_body.hpp"

namespace fanlight {

/// Puts an image together from messages that carry parts of it (sub-volumes). An image begins with the part
/// at its first pixel, and is whole when as many pixels have come as it has; parts in any order between. One
/// thread. Memory of one image.
class ImageParts {
 public:
  enum class State : std::uint8_t {
    kMore,   ///< parts are still to come
    kWhole,  ///< pixels() are whole
    kCut,    ///< this part begins an image, or is of another one, and the last one is not whole
    kStray,  ///< a part of an image whose begin was not seen
  };

  /// Precondition: a 2D image, which parse_image() took.
  State add(const igtl::ReceivedImage& part);

  /// The image that has begun, if there is one, is not continued. Whether there was one.
  bool abandon() { return std::exchange(bytes_, 0) > 0; }

  /// All pixels of the image, as stored. Valid until the next call.
  std::span<const std::uint8_t> pixels() const { return pixels_; }

 private:
  bool is_of_this_image(const igtl::ImageBody& part) const;
  void copy(const igtl::ReceivedImage& part);

  igtl::ImageBody image_;
  std::vector<std::uint8_t> pixels_;
  std::uint64_t bytes_ = 0;  // received so far; 0: no image has begun
};

}  // namespace fanlight
