// SPDX-License-Identifier: Apache-2.0
#include "server/codec/reduced_picture.hpp"

#include <cmath>
#include <span>

#include "server/codec/picture_coder.hpp"

namespace fanlight {

namespace {

/// Of a map of the picture, the values at the centres of the larger pixels.
template <typename Value>
std::vector<Value> reduced_map(std::span<const Value> map, PictureSize from, PictureSize to) {
  if (map.size() != from.pixels()) return {};
  std::vector<Value> reduced;
  reduced.reserve(to.pixels());
  // The pixel that the centre of one of the smaller map lies in.
  const auto at = [](std::uint32_t index, std::uint32_t few, std::uint32_t many) {
    return static_cast<std::size_t>((2 * std::uint64_t{index} + 1) * many / (2 * std::uint64_t{few}));
  };
  for (std::uint32_t row = 0; row < to.height; ++row) {
    const auto line = map.subspan(at(row, to.height, from.height) * from.width, from.width);
    for (std::uint32_t column = 0; column < to.width; ++column)
      reduced.push_back(line[at(column, to.width, from.width)]);
  }
  return reduced;
}

PictureSize size_of(const Picture& picture) {
  return {.width = picture.width, .height = picture.height};
}

SurfacePart scaled(const SurfacePart& part, double scale) {
  const auto at = [scale](std::uint32_t pixels) {
    return static_cast<std::uint32_t>(std::lround(pixels * scale));
  };
  SurfacePart made = part;
  made.left = at(part.left);
  made.top = at(part.top);
  made.width = at(part.left + part.width) - made.left;
  made.height = at(part.top + part.height) - made.top;
  return made;
}

}  // namespace

PictureView scaled(const PictureView& view, double scale) {
  PictureView made = view;
  made.mm_per_pixel /= scale;
  made.mm_per_pixel_per_mm /= scale;
  // Pixels are counted at their centres.
  made.middle_column = (view.middle_column + 0.5) * scale - 0.5;
  made.middle_row = (view.middle_row + 0.5) * scale - 0.5;
  made.part = scaled(view.part, scale);
  return made;
}

std::vector<float> reduced_depths(const Picture& picture, PictureSize size) {
  return reduced_map<float>(picture.depth_mm, size_of(picture), size);
}

Picture reduced(const Picture& picture, PictureSize size) {
  Picture made{.stamp = picture.stamp, .width = size.width, .height = size.height};
  made.stamp.view = scaled(picture.stamp.view, static_cast<double>(size.height) / picture.height);
  PictureScaler scaler;
  const Pixels pixels = scaler.fitted(
      pixels_of(picture),
      {.codec = StreamSettings::Codec::kPng, .most_width = size.width, .most_height = size.height});
  made.rgba.assign(pixels.rgba.begin(), pixels.rgba.end());
  made.width = pixels.width;
  made.height = pixels.height;
  made.depth_mm = reduced_depths(picture, {made.width, made.height});
  made.certainty = reduced_map<std::uint8_t>(picture.certainty, size_of(picture), {made.width, made.height});
  return made;
}

}  // namespace fanlight
