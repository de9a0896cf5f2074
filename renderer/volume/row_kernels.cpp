// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/row_kernels.hpp"

// Highway includes this file once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/volume/row_kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace fanlight::row_kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A step of most loops handles one vector of words; narrower values have as many lanes.
constexpr hn::CappedTag<std::uint32_t, kVectorBytes / sizeof(std::uint32_t)> kWords;
constexpr hn::RebindToSigned<decltype(kWords)> kIntegers;
constexpr hn::RebindToFloat<decltype(kWords)> kFloats;
constexpr hn::Rebind<std::uint16_t, decltype(kWords)> kHalves;
constexpr hn::Rebind<std::uint8_t, decltype(kWords)> kBytes;
constexpr hn::CappedTag<std::uint8_t, kVectorBytes> kAllBytes;

using Words = hn::Vec<decltype(kWords)>;
using Integers = hn::Vec<decltype(kIntegers)>;
using Floats = hn::Vec<decltype(kFloats)>;
using Bytes = hn::Vec<decltype(kAllBytes)>;

HWY_INLINE Words words(const std::uint8_t* from) {
  return hn::PromoteTo(kWords, hn::LoadU(kBytes, from));
}
HWY_INLINE Words words(const std::uint16_t* from) {
  return hn::PromoteTo(kWords, hn::LoadU(kHalves, from));
}

// Of values below 2^31.
HWY_INLINE Floats floats(Words values) {
  return hn::ConvertTo(kFloats, hn::BitCast(kIntegers, values));
}

// Pixels of the windows from a column on; 1 behind the last one, where a vector may end.
HWY_INLINE Words pixels_in(const Windows& windows, std::size_t column) {
  const Words across = hn::LoadU(kWords, windows.across + column);
  return hn::Max(hn::Mul(across, hn::Set(kWords, windows.rest)), hn::Set(kWords, 1));
}

HWY_INLINE void store_bytes(Words values, std::uint8_t* to) {
  hn::StoreU(hn::DemoteTo(kBytes, hn::BitCast(kIntegers, values)), kBytes, to);
}

// The sum over the window of each column.
HWY_INLINE Words window_sum(const std::uint32_t* column, std::size_t radius) {
  Words sum = hn::LoadU(kWords, column);
  for (std::size_t away = 1; away <= radius; ++away) {
    sum = hn::Add(sum, hn::Add(hn::LoadU(kWords, column - away), hn::LoadU(kWords, column + away)));
  }
  return sum;
}
HWY_INLINE Words window_sum(const std::uint16_t* column, std::size_t radius) {
  auto sum = hn::LoadU(kHalves, column);
  for (std::size_t away = 1; away <= radius; ++away) {
    sum = hn::Add(sum, hn::Add(hn::LoadU(kHalves, column - away), hn::LoadU(kHalves, column + away)));
  }
  return hn::PromoteTo(kWords, sum);
}

// A filter's result, which stays "not scanned" or an echo as the pixel was (frame_words.h).
HWY_INLINE Words kept_scanned(Words filtered, Words grey) {
  const Words one = hn::Set(kWords, 1);
  return hn::IfThenElseZero(hn::Ne(grey, hn::Zero(kWords)), hn::Max(filtered, one));
}

void slide(const ColumnSums& sums, const std::uint8_t* entering, const std::uint8_t* leaving,
           std::size_t columns) {
  constexpr hn::CappedTag<std::uint16_t, kVectorBytes / sizeof(std::uint16_t)> kShorts;
  constexpr hn::Rebind<std::uint8_t, decltype(kShorts)> kShortBytes;
  const auto one = hn::Set(kShorts, 1);
  for (std::size_t column = 0; column < columns; column += hn::Lanes(kShorts)) {
    const auto in = hn::PromoteTo(kShorts, hn::LoadU(kShortBytes, entering + column));
    const auto out = hn::PromoteTo(kShorts, hn::LoadU(kShortBytes, leaving + column));
    const auto grey = hn::LoadU(kShorts, sums.grey + column);
    hn::StoreU(hn::Sub(hn::Add(grey, in), out), kShorts, sums.grey + column);
    if (sums.scanned != nullptr) {
      const auto scanned = hn::LoadU(kShorts, sums.scanned + column);
      hn::StoreU(hn::Sub(hn::Add(scanned, hn::Min(in, one)), hn::Min(out, one)), kShorts,
                 sums.scanned + column);
    }
  }
  if (sums.squares == nullptr) return;
  for (std::size_t column = 0; column < columns; column += hn::Lanes(kWords)) {
    // A difference of squares may be negative; the sum wraps back.
    const Words in = words(entering + column);
    const Words out = words(leaving + column);
    const Words grown = hn::Mul(hn::Sub(in, out), hn::Add(in, out));
    hn::StoreU(hn::Add(hn::LoadU(kWords, sums.squares + column), grown), kWords, sums.squares + column);
  }
}

// As packUnorm2x16, of values from 0 on.
HWY_INLINE Words unorm16(Floats value) {
  const Floats inside = hn::Min(value, hn::Set(kFloats, 1.0F));
  return hn::BitCast(kWords, hn::NearestInt(hn::Mul(inside, hn::Set(kFloats, 65535.0F))));
}

HWY_INLINE void add_to(std::uint32_t* sum, Words added) {
  hn::StoreU(hn::Add(hn::LoadU(kWords, sum), added), kWords, sum);
}

void add_lines(const ColumnSums& sums, const Windows& windows, float noise, float levels,
               const Lines& lines) {
  const Words one = hn::Set(kWords, 1);
  const Floats zero = hn::Zero(kFloats);
  const Floats unit = hn::Set(kFloats, 1.0F);
  const Floats added = hn::Set(kFloats, levels * levels);
  for (std::size_t column = 0; column < windows.columns; column += hn::Lanes(kWords)) {
    const Words sum = window_sum(sums.grey + column, windows.radius);
    const Words squares = window_sum(sums.squares + column, windows.radius);
    const Words number = sums.scanned != nullptr
                             ? hn::Max(window_sum(sums.scanned + column, windows.radius), one)
                             : pixels_in(windows, column);
    const Floats pixels = floats(number);
    const Floats mean = hn::Div(floats(sum), pixels);
    // In whole numbers: with at most 147 pixels of at most 255 both products are below 2^31.
    const Floats spread = floats(hn::Sub(hn::Mul(squares, number), hn::Mul(sum, sum)));
    const Floats variance = hn::Div(spread, hn::Mul(pixels, pixels));
    const Floats multiplied = hn::Mul(hn::Set(kFloats, noise), mean);
    const Floats speckle = hn::Add(hn::Mul(multiplied, multiplied), added);
    const Floats share = hn::IfThenElse(hn::Gt(variance, zero), hn::Div(speckle, variance), unit);
    const Floats a = hn::Max(hn::Sub(unit, share), zero);
    const Floats b = hn::Div(hn::Mul(hn::Sub(unit, a), mean), hn::Set(kFloats, 255.0F));
    add_to(lines.a + column, unorm16(a));
    add_to(lines.b + column, unorm16(b));
  }
  // The last step may have gone beyond the frame, where there are no windows.
  hn::StoreU(hn::Zero(kWords), kWords, lines.a + windows.columns);
  hn::StoreU(hn::Zero(kWords), kWords, lines.b + windows.columns);
}

void slide_lines(const Lines& sums, const Lines& entering, const Lines& leaving, std::size_t columns) {
  for (std::size_t column = 0; column < columns; column += hn::Lanes(kWords)) {
    add_to(sums.a + column,
           hn::Sub(hn::LoadU(kWords, entering.a + column), hn::LoadU(kWords, leaving.a + column)));
    add_to(sums.b + column,
           hn::Sub(hn::LoadU(kWords, entering.b + column), hn::LoadU(kWords, leaving.b + column)));
  }
}

void apply_lines(const Lines& sums, const Windows& windows, const std::uint8_t* grey, bool keeps_zero,
                 std::uint8_t* filtered) {
  for (std::size_t column = 0; column < windows.columns; column += hn::Lanes(kWords)) {
    const Words number = pixels_in(windows, column);
    const Floats scale = hn::Div(hn::Set(kFloats, 1.0F), hn::Mul(hn::Set(kFloats, 65535.0F), floats(number)));
    const Words pixels = words(grey + column);
    const Floats a = hn::Mul(scale, floats(window_sum(sums.a + column, windows.radius)));
    const Floats b = hn::Mul(hn::Mul(hn::Set(kFloats, 255.0F), scale),
                             floats(window_sum(sums.b + column, windows.radius)));
    const Floats value = hn::Add(hn::Mul(a, floats(pixels)), b);
    const Floats rounded = hn::Min(hn::Add(value, hn::Set(kFloats, 0.5F)), hn::Set(kFloats, 255.0F));
    const Words whole = hn::BitCast(kWords, hn::ConvertTo(kIntegers, rounded));
    store_bytes(keeps_zero ? kept_scanned(whole, pixels) : whole, filtered + column);
  }
}

void take_means(const ColumnSums& sums, const Windows& windows, const std::uint8_t* grey,
                std::uint8_t* filtered) {
  const Words one = hn::Set(kWords, 1);
  for (std::size_t column = 0; column < windows.columns; column += hn::Lanes(kWords)) {
    const Words sum = window_sum(sums.grey + column, windows.radius);
    const bool masked = sums.scanned != nullptr;
    const Words number =
        masked ? hn::Max(window_sum(sums.scanned + column, windows.radius), one) : pixels_in(windows, column);
    // The quotient of such small numbers is exact enough to be cut off: it is 1/294 away from the next whole
    // number.
    const Floats mean = hn::Div(floats(hn::Add(hn::Add(sum, sum), number)), floats(hn::Add(number, number)));
    const Words whole = hn::BitCast(kWords, hn::ConvertTo(kIntegers, mean));
    store_bytes(masked ? kept_scanned(whole, words(grey + column)) : whole, filtered + column);
  }
}

// How many pixels of a window are at most `most`. Counts of at most 147 pixels fit in a byte.
HWY_INLINE Bytes count_up_to(Bytes most, const MedianRows& window, std::size_t column) {
  const Bytes one = hn::Set(kAllBytes, 1);
  const auto radius = static_cast<std::ptrdiff_t>(window.radius);
  Bytes number = hn::Zero(kAllBytes);
  for (std::size_t row = 0; row < window.count; ++row) {
    for (std::ptrdiff_t away = -radius; away <= radius; ++away) {
      const Bytes grey = hn::LoadU(kAllBytes, window.rows[row] + column + away);
      number = hn::Add(number, hn::IfThenElseZero(hn::Eq(hn::Min(grey, most), grey), one));
    }
  }
  return number;
}

void take_medians(const MedianRows& window, const std::uint8_t* grey, bool keeps_zero,
                  std::uint8_t* filtered) {
  const Bytes zero = hn::Zero(kAllBytes);
  const Bytes all = hn::Set(kAllBytes, static_cast<std::uint8_t>(window.count * (2 * window.radius + 1)));
  for (std::size_t column = 0; column < window.columns; column += hn::Lanes(kAllBytes)) {
    // Pixels outside the frame are 0 here. Those are not counted, nor zeros that were not scanned.
    const Bytes present = keeps_zero ? hn::Sub(all, count_up_to(zero, window, column))
                                     : hn::LoadU(kAllBytes, window.present + column);
    const Bytes absent = hn::Sub(all, present);
    // The smallest grey level that at least half of the pixels, rounded up, do not exceed.
    Bytes median = zero;
    for (int half = 128; half > 0; half /= 2) {
      const Bytes step = hn::Set(kAllBytes, static_cast<std::uint8_t>(half));
      const Bytes most = hn::Add(median, hn::Set(kAllBytes, static_cast<std::uint8_t>(half - 1)));
      const Bytes below = hn::Sub(count_up_to(most, window, column), absent);
      const auto enough = hn::Eq(hn::Max(below, hn::Sub(present, below)), below);
      median = hn::IfThenElse(enough, median, hn::Add(median, step));
    }
    if (keeps_zero) {
      const auto scanned = hn::Ne(hn::LoadU(kAllBytes, grey + column), zero);
      median = hn::IfThenElseZero(scanned, hn::Max(median, hn::Set(kAllBytes, 1)));
    }
    hn::StoreU(median, kAllBytes, filtered + column);
  }
}

void pack(const FourRows& rows, std::size_t columns, std::uint32_t* to) {
  for (std::size_t column = 0; column < columns; column += hn::Lanes(kWords)) {
    const Words low = hn::Or(words(rows[0] + column), hn::ShiftLeft<8>(words(rows[1] + column)));
    const Words high =
        hn::Or(hn::ShiftLeft<16>(words(rows[2] + column)), hn::ShiftLeft<24>(words(rows[3] + column)));
    hn::StoreU(hn::Or(low, high), kWords, to + column);
  }
}

#if HWY_TARGET == HWY_SCALAR
// A vector has one byte here, and a block four.
void find_bounds(const FourRows& rows, std::size_t columns, std::uint16_t* bounds) {
  for (std::size_t first = 0; first < columns; first += 4) {
    unsigned least = 255;
    unsigned greatest = 0;
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t column = first; column < columns && column < first + 4; ++column) {
        const unsigned grey = rows[row][column];
        least = grey < least ? grey : least;
        greatest = grey > greatest ? grey : greatest;
      }
    }
    bounds[first / 4] = static_cast<std::uint16_t>(255 - least + 256 * greatest);
  }
}
#else
// The greatest of the four bytes of each word, in its lowest byte.
HWY_INLINE Words greatest_of_four(Bytes bytes) {
  const Bytes two = hn::Max(bytes, hn::BitCast(kAllBytes, hn::ShiftRight<8>(hn::BitCast(kWords, bytes))));
  const Bytes four = hn::Max(two, hn::BitCast(kAllBytes, hn::ShiftRight<16>(hn::BitCast(kWords, two))));
  return hn::And(hn::BitCast(kWords, four), hn::Set(kWords, 0xFF));
}

void find_bounds(const FourRows& rows, std::size_t columns, std::uint16_t* bounds) {
  const Bytes all = hn::Set(kAllBytes, 255);
  for (std::size_t column = 0; column < columns; column += hn::Lanes(kAllBytes)) {
    Bytes greatest = hn::LoadU(kAllBytes, rows[0] + column);
    Bytes least = greatest;
    for (std::size_t row = 1; row < 4; ++row) {
      const Bytes grey = hn::LoadU(kAllBytes, rows[row] + column);
      greatest = hn::Max(greatest, grey);
      least = hn::Min(least, grey);
    }
    // What lies behind the last column is not part of the frame.
    const std::size_t left = columns - column;
    const std::size_t lanes = hn::Lanes(kAllBytes);
    const auto inside = hn::FirstN(kAllBytes, left < lanes ? left : lanes);  // compares bytes
    const Words low = greatest_of_four(hn::IfThenElseZero(inside, hn::Xor(least, all)));
    const Words high = greatest_of_four(hn::IfThenElseZero(inside, greatest));
    const Words packed = hn::Or(low, hn::ShiftLeft<8>(high));
    hn::StoreU(hn::DemoteTo(kHalves, hn::BitCast(kIntegers, packed)), kHalves, bounds + column / 4);
  }
}
#endif

void join_bounds(const FourRowsOfBounds& rows, std::size_t blocks, std::uint32_t* joined) {
  const Words low_byte = hn::Set(kWords, 0xFF);
  for (std::size_t block = 0; block < blocks; block += hn::Lanes(kWords)) {
    Words low = hn::Zero(kWords);
    Words high = hn::Zero(kWords);
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t across = 0; across < 4; ++across) {
        const Words bounds = words(rows[row] + block + across);
        low = hn::Max(low, hn::And(bounds, low_byte));
        high = hn::Max(high, hn::ShiftRight<8>(bounds));
      }
    }
    hn::StoreU(hn::Or(hn::Xor(low, low_byte), hn::ShiftLeft<8>(high)), kWords, joined + block);
  }
}

}  // namespace fanlight::row_kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fanlight::row_kernels {

HWY_EXPORT(slide);
void slide(const ColumnSums& sums, const std::uint8_t* entering, const std::uint8_t* leaving,
           std::size_t columns) {
  HWY_DYNAMIC_DISPATCH(slide)(sums, entering, leaving, columns);
}

HWY_EXPORT(add_lines);
void add_lines(const ColumnSums& sums, const Windows& windows, float noise, float levels,
               const Lines& lines) {
  HWY_DYNAMIC_DISPATCH(add_lines)(sums, windows, noise, levels, lines);
}

HWY_EXPORT(slide_lines);
void slide_lines(const Lines& sums, const Lines& entering, const Lines& leaving, std::size_t columns) {
  HWY_DYNAMIC_DISPATCH(slide_lines)(sums, entering, leaving, columns);
}

HWY_EXPORT(apply_lines);
void apply_lines(const Lines& sums, const Windows& windows, const std::uint8_t* grey, bool keeps_zero,
                 std::uint8_t* filtered) {
  HWY_DYNAMIC_DISPATCH(apply_lines)(sums, windows, grey, keeps_zero, filtered);
}

HWY_EXPORT(take_means);
void take_means(const ColumnSums& sums, const Windows& windows, const std::uint8_t* grey,
                std::uint8_t* filtered) {
  HWY_DYNAMIC_DISPATCH(take_means)(sums, windows, grey, filtered);
}

HWY_EXPORT(take_medians);
void take_medians(const MedianRows& window, const std::uint8_t* grey, bool keeps_zero,
                  std::uint8_t* filtered) {
  HWY_DYNAMIC_DISPATCH(take_medians)(window, grey, keeps_zero, filtered);
}

HWY_EXPORT(pack);
void pack(const FourRows& rows, std::size_t columns, std::uint32_t* words) {
  HWY_DYNAMIC_DISPATCH(pack)(rows, columns, words);
}

HWY_EXPORT(find_bounds);
void find_bounds(const FourRows& rows, std::size_t columns, std::uint16_t* bounds) {
  HWY_DYNAMIC_DISPATCH(find_bounds)(rows, columns, bounds);
}

HWY_EXPORT(join_bounds);
void join_bounds(const FourRowsOfBounds& rows, std::size_t blocks, std::uint32_t* joined) {
  HWY_DYNAMIC_DISPATCH(join_bounds)(rows, blocks, joined);
}

}  // namespace fanlight::row_kernels
#endif
