// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/image_parts.hpp"

#include <algorithm>
#include <array>

namespace fanlight {

ImageParts::State ImageParts::add(const igtl::ReceivedImage& part) {
  const bool begins = part.body.part_offset == std::array<std::uint16_t, 3>{};
  const bool was_open = bytes_ > 0;
  const bool continues = was_open && !begins && is_of_this_image(part.body);
  if (!begins && !continues) {
    bytes_ = 0;
    return was_open ? State::kCut : State::kStray;
  }
  if (begins) {
    image_ = part.body;
    const std::uint64_t pixel_bytes = image_.components * igtl::bytes_of(image_.scalar);
    pixels_.resize(std::uint64_t{image_.size[0]} * image_.size[1] * pixel_bytes);
    received_.assign(std::size_t{image_.size[0]} * image_.size[1], false);
    bytes_ = 0;
  }
  if (overlaps(part)) {
    bytes_ = 0;
    return State::kCut;
  }
  copy(part);
  bytes_ += part.pixels.size();
  if (bytes_ < pixels_.size()) return begins && was_open ? State::kCut : State::kMore;
  bytes_ = 0;
  return State::kWhole;
}

bool ImageParts::is_of_this_image(const igtl::ImageBody& part) const {
  return part.size == image_.size && part.scalar == image_.scalar && part.components == image_.components &&
         part.big_endian == image_.big_endian;
}

/// Whether a pixel of the part has come before; notes all of them.
bool ImageParts::overlaps(const igtl::ReceivedImage& part) {
  bool any = false;
  for (std::size_t row = 0; row < part.body.part_size[1]; ++row) {
    const std::size_t first = (part.body.part_offset[1] + row) * image_.size[0] + part.body.part_offset[0];
    for (std::size_t pixel = first; pixel < first + part.body.part_size[0]; ++pixel) {
      any = any || received_[pixel];
      received_[pixel] = true;
    }
  }
  return any;
}

void ImageParts::copy(const igtl::ReceivedImage& part) {
  const std::size_t pixel_bytes = part.body.components * igtl::bytes_of(part.body.scalar);
  const std::size_t row_bytes = part.body.part_size[0] * pixel_bytes;
  for (std::size_t row = 0; row < part.body.part_size[1]; ++row) {
    const std::size_t to_row = part.body.part_offset[1] + row;
    const std::size_t to = (to_row * part.body.size[0] + part.body.part_offset[0]) * pixel_bytes;
    std::ranges::copy(part.pixels.subspan(row * row_bytes, row_bytes), pixels_.begin() + to);
  }
}

}  // namespace fanlight
