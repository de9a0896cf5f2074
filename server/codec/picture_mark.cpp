// SPDX-License-Identifier: Apache-2.0
#include "server/codec/picture_mark.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "server/codec/picture_coder.hpp"

namespace fanlight {

namespace {

constexpr std::uint32_t kGlyphWidth = 5;
constexpr std::uint32_t kGlyphHeight = 7;
constexpr std::uint32_t kAdvance = kGlyphWidth + 1;

/// A letter: its rows from the top, five bits each, the left one first.
struct Glyph {
  char letter;
  std::array<std::uint8_t, kGlyphHeight> rows;
};

// The letters of the words alone: a library of fonts would need a font on every server.
constexpr auto kGlyphs = std::to_array<Glyph>({
    {'A', {0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001}},
    {'D', {0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110}},
    {'E', {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111}},
    {'F', {0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'I', {0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110}},
    {'L', {0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111}},
    {'M', {0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001}},
    {'N', {0b10001, 0b11001, 0b10101, 0b10101, 0b10011, 0b10001, 0b10001}},
    {'O', {0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'P', {0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000}},
    {'R', {0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001}},
    {'S', {0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110}},
    {'T', {0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100}},
    {'U', {0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110}},
    {'V', {0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100}},
    {'Y', {0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100, 0b00100}},
    {'Z', {0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b11111}},
});

using Colour = std::array<std::uint8_t, 4>;
constexpr Colour kWhite = {255, 255, 255, 255};

/// Of the field: white letters have a contrast of 4.5 or more on each (WCAG 2.1, 1.4.3).
Colour field_colour(PictureMark mark) {
  switch (mark) {
    case PictureMark::kFrozen:
      return {20, 80, 160, 255};
    case PictureMark::kReplay:
    case PictureMark::kSimulated:
      return {70, 70, 70, 255};
    default:
      return {190, 20, 20, 255};
  }
}

/// Pixels that can be written.
struct Canvas {
  std::uint32_t width;
  std::uint32_t height;
  std::span<std::uint8_t> rgba;

  void fill(std::uint32_t left, std::uint32_t top, std::uint32_t columns, std::uint32_t rows,
            const Colour& colour) const {
    const std::uint32_t right = std::min(width, left + columns);
    const std::uint32_t bottom = std::min(height, top + rows);
    for (std::uint32_t row = top; row < bottom; ++row)
      for (std::uint32_t column = left; column < right; ++column)
        std::ranges::copy(colour, rgba.begin() + 4 * (std::ptrdiff_t{row} * width + column));
  }
};

void draw_words(const Canvas& canvas, std::string_view words, std::uint32_t dot) {
  std::uint32_t left = 2 * dot;
  for (const char letter : words) {
    const auto* const glyph = std::ranges::find(kGlyphs, letter, &Glyph::letter);
    for (std::uint32_t row = 0; glyph != kGlyphs.end() && row < kGlyphHeight; ++row)
      for (std::uint32_t column = 0; column < kGlyphWidth; ++column)
        if ((glyph->rows.at(row) >> (kGlyphWidth - 1 - column) & 1U) != 0)
          canvas.fill(left + column * dot, (2 + row) * dot, dot, dot, kWhite);
    left += kAdvance * dot;
  }
}

}  // namespace

std::string_view mark_words(PictureMark mark) {
  constexpr std::array<std::string_view, 6> kWords = {"",       "NOT LIVE", "DELAYED",
                                                      "FROZEN", "REPLAY",   "SIMULATED"};
  return kWords.at(static_cast<std::size_t>(mark));
}

Pixels PictureMarker::marked(const Pixels& pixels, PictureMark mark) {
  if (mark == PictureMark::kNone) return pixels;
  rgba_.assign(pixels.rgba.begin(), pixels.rgba.end());
  const Canvas canvas{.width = pixels.width, .height = pixels.height, .rgba = rgba_};
  const std::string_view words = mark_words(mark);
  const std::uint32_t columns = static_cast<std::uint32_t>(words.size()) * kAdvance + 3;  // dots of the field
  constexpr std::uint32_t kRows = kGlyphHeight + 4;
  const std::uint32_t dot = std::min(std::max(1U, (pixels.height + 60) / 120), pixels.width / columns);
  if (dot == 0) {
    canvas.fill(0, 0, pixels.width, std::max(2U, pixels.height / 8), field_colour(mark));
  } else {
    canvas.fill(0, 0, columns * dot, kRows * dot, field_colour(mark));
    draw_words(canvas, words, dot);
  }
  return {.width = pixels.width, .height = pixels.height, .rgba = rgba_};
}

}  // namespace fanlight
