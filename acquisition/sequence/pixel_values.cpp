// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fanlight {

namespace {

/// Calls `take` with the bits of each stored pixel, as an unsigned number.
template <typename Take>
void for_each_code(PixelFormat format, std::span<const std::uint8_t> stored, Take take) {
  if (format.bytes == 1) {
    for (const std::uint8_t code : stored) take(std::size_t{code});
    return;
  }
  const std::size_t high = format.big_endian ? 0 : 1;
  for (std::size_t i = 0; i + 1 < stored.size(); i += 2)
    take(std::size_t{stored[i + high]} << 8 | stored[i + 1 - high]);
}

/// The value with these bits.
int value_of(PixelFormat format, std::size_t code) {
  const auto value = static_cast<int>(code);
  return format.is_signed && value > format.largest() ? value - (format.bytes == 1 ? 256 : 65'536) : value;
}

}  // namespace

std::string_view PixelFormat::name() const {
  if (bytes == 1) return is_signed ? "8 bit signed" : "8 bit";
  return is_signed ? "16 bit signed" : "16 bit";
}

ValueWindow whole_window(PixelFormat format) {
  return {.black = static_cast<double>(format.smallest()), .white = static_cast<double>(format.largest())};
}

GreyLevels::GreyLevels(PixelFormat format, const ValueWindow& window,
                       std::optional<std::uint32_t> unscanned_code)
    : format_(format), of_code_(std::size_t{1} << (8 * format.bytes)) {
  for (std::size_t code = 0; code < of_code_.size(); ++code) {
    const double share = (value_of(format, code) - window.black) / (window.white - window.black);
    of_code_[code] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
    if (unscanned_code)
      of_code_[code] = code == *unscanned_code ? 0 : std::max<std::uint8_t>(of_code_[code], 1);
  }
}

void GreyLevels::convert(std::span<const std::uint8_t> stored, std::span<std::uint8_t> grey) const {
  std::size_t at = 0;
  for_each_code(format_, stored, [&](std::size_t code) { grey[at++] = of_code_[code]; });
}

void ValueHistogram::add(std::span<const std::uint8_t> stored, std::optional<std::uint32_t> unscanned_code) {
  for_each_code(format_, stored, [&](std::size_t code) {
    if (code == unscanned_code) return;
    ++counts_[static_cast<std::size_t>(value_of(format_, code) - format_.smallest())];
  });
}

ValueWindow ValueHistogram::window() const {
  constexpr double kBeyond = 0.001;
  const std::uint64_t all = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
  const auto beyond = static_cast<std::uint64_t>(kBeyond * static_cast<double>(all));
  const auto reach = [beyond](auto from, auto end) {
    std::uint64_t passed = 0;
    auto at = from;
    while (at != end && (passed += *at) <= beyond) ++at;
    return at - from;
  };
  const auto low = reach(counts_.begin(), counts_.end());
  const auto high = reach(counts_.rbegin(), counts_.rend());
  const ValueWindow found{.black = static_cast<double>(format_.smallest() + low),
                          .white = static_cast<double>(format_.largest() - high)};
  return found.black < found.white ? found : whole_window(format_);
}

}  // namespace fanlight
