// SPDX-License-Identifier: Apache-2.0
#include "proto/model/picture_size_text.hpp"

#include <fmt/format.h>

#include <charconv>

#include "proto/base/printable.hpp"

namespace fanlight {

Result<PictureSize> parse_picture_size(std::string_view text) {
  constexpr std::uint32_t kSmallest = 16;
  constexpr std::uint32_t kLargest = 2048;  // on a CPU, lighting a larger picture takes seconds
  PictureSize size{};
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  const bool cross = width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x';
  const auto height = cross ? std::from_chars(width.ptr + 1, end, size.height) : width;
  const auto fits = [](std::uint32_t side) { return side >= kSmallest && side <= kLargest; };
  if (!cross || height.ec != std::errc{} || height.ptr != end || !fits(size.width) || !fits(size.height)) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("the picture size is \"{}\", expected WIDTHxHEIGHT such as 512x512, {} to {} each",
                    printable(text.substr(0, 40)), kSmallest, kLargest)};
  }
  return size;
}

}  // namespace fanlight
