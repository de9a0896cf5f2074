// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace fanlight {

/// How a file stores a pixel.
struct PixelFormat {
  std::uint32_t bytes = 1;  ///< 1 or 2
  bool is_signed = false;
  bool big_endian = false;  ///< with 2 bytes

  /// "8 bit", "16 bit signed"
  std::string_view name() const;
  int smallest() const { return is_signed ? (bytes == 1 ? -128 : -32'768) : 0; }
  int largest() const { return smallest() + (bytes == 1 ? 255 : 65'535); }
  /// Whether its values are grey levels as they are.
  bool is_grey() const { return bytes == 1 && !is_signed; }
  bool operator==(const PixelFormat&) const = default;
};

/// Values that are shown black and white; those beyond are clamped, those between are proportional.
struct ValueWindow {
  double black = 0;
  double white = 255;
  bool operator==(const ValueWindow&) const = default;
};

/// The window that shows all values of the format.
ValueWindow whole_window(PixelFormat format);

/// Converts stored pixels to grey levels, 0 to 255.
class GreyLevels {
 public:
  /// Precondition: window.black < window.white. `unscanned_code`: the bits of a value that becomes 0; all
  /// others become 1 or more then.
  GreyLevels(PixelFormat format, const ValueWindow& window, std::optional<std::uint32_t> unscanned_code = {});

  /// `stored`: format.bytes for each of the pixels of `grey`.
  void convert(std::span<const std::uint8_t> stored, std::span<std::uint8_t> grey) const;

 private:
  PixelFormat format_;
  std::vector<std::uint8_t> of_code_;  // by the value's bits, as an unsigned number
};

/// Counts values, to choose a window by them.
class ValueHistogram {
 public:
  explicit ValueHistogram(PixelFormat format)
      : format_(format), counts_(std::size_t{1} << (8 * format.bytes)) {}
  /// `unscanned_code`: the bits of a value that does not count.
  void add(std::span<const std::uint8_t> stored, std::optional<std::uint32_t> unscanned_code = {});
  /// From the value that 0.1 % lie below to the one that 0.1 % lie above: single bright pixels do not darken
  /// the picture. The whole window where all values are equal.
  ValueWindow window() const;

 private:
  PixelFormat format_;
  std::vector<std::uint64_t> counts_;  // by the value, from the smallest
};

}  // namespace fanlight
