// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sequence/pixel_values.hpp"

#include <gtest/gtest.h>

namespace fanlight {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes grey(PixelFormat format, const ValueWindow& window, const Bytes& stored) {
  Bytes levels(stored.size() / format.bytes);
  GreyLevels(format, window).convert(stored, levels);
  return levels;
}

TEST(GreyLevelsTest, ReadsEachFormat) {
  const ValueWindow window{.black = 0, .white = 510};
  EXPECT_EQ(grey({.bytes = 2}, window, {0x00, 0x00, 0xFE, 0x01, 0x02, 0x00}), (Bytes{0, 255, 1}));
  EXPECT_EQ(grey({.bytes = 2, .big_endian = true}, window, {0x00, 0x00, 0x01, 0xFE, 0x00, 0x02}),
            (Bytes{0, 255, 1}));
  EXPECT_EQ(grey({.is_signed = true}, whole_window({.is_signed = true}), {0x80, 0x00, 0x7F}),
            (Bytes{0, 128, 255}));
  const PixelFormat signed_16{.bytes = 2, .is_signed = true};
  EXPECT_EQ(grey(signed_16, {.black = -10, .white = 0}, {0xF6, 0xFF, 0xFB, 0xFF, 0x00, 0x00}),
            (Bytes{0, 128, 255}));
}

TEST(GreyLevelsTest, ClampsBeyondTheWindow) {
  EXPECT_EQ(grey({.bytes = 2}, {.black = 100, .white = 200}, {99, 0, 0xFF, 0xFF, 150, 0}),
            (Bytes{0, 255, 128}));
}

TEST(ValueHistogramTest, LeavesOutAThousandthAtEitherEnd) {
  const PixelFormat format{.bytes = 2, .is_signed = true};
  ValueHistogram histogram(format);
  const auto add = [&](int value, int times) {
    const auto code = static_cast<std::uint16_t>(value);
    for (int i = 0; i < times; ++i)
      histogram.add(Bytes{static_cast<std::uint8_t>(code & 255), static_cast<std::uint8_t>(code >> 8)});
  };
  add(-50, 5000);
  add(900, 4990);
  add(32'000, 5);
  add(-32'000, 5);
  EXPECT_EQ(histogram.window(), (ValueWindow{.black = -50, .white = 900}));
}

TEST(ValueHistogramTest, ShowsAllWhereNothingDiffers) {
  const PixelFormat format{.bytes = 2};
  ValueHistogram histogram(format);
  EXPECT_EQ(histogram.window(), whole_window(format));
  histogram.add(Bytes{7, 0, 7, 0});
  EXPECT_EQ(histogram.window(), whole_window(format));
}

}  // namespace
}  // namespace fanlight
