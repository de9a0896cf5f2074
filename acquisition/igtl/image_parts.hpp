// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "proto/igtl/image_body.hpp"

namespace fanlight {

/// Puts an image together from messages that carry parts of it (sub-volumes). An image begins with the part
/// at its first pixel, and is whole when each of its pixels has come; parts in any order between. A part that
/// overlaps another one ends the image: it would leave pixels of the image before. One thread. Memory of one
/// image, and a bit for each of its pixels.
class ImageParts {
 public:
  enum class State : std::uint8_t {
    kMore,   ///< parts are still to come
    kWhole,  ///< pixels() are whole
    kCut,    ///< this part begins an image, is of another one, or overlaps, and the last one is not whole
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
  bool overlaps(const igtl::ReceivedImage& part);
  void copy(const igtl::ReceivedImage& part);

  igtl::ImageBody image_;
  std::vector<std::uint8_t> pixels_;
  std::vector<bool> received_;  // for each pixel
  std::uint64_t bytes_ = 0;     // received so far; 0: no image has begun
};

}  // namespace fanlight
