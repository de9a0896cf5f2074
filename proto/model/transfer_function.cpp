// SPDX-License-Identifier: Apache-2.0
#include "proto/model/transfer_function.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace fanlight {

namespace {

constexpr double kMostOpacity = 0.999;

/// Removes the next word from `text` and returns it; empty at the end.
std::string_view next_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const std::string_view word = text.substr(0, text.find(' '));
  text.remove_prefix(word.size());
  return word;
}

template <typename T, typename... Base>
std::optional<T> number(std::string_view text, Base... base) {
  T value{};
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value, base...);
  if (failure != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<TransferFunction::Point> point(std::string_view text) {
  const auto level = number<std::uint8_t>(next_word(text));
  const std::string_view colour = next_word(text);
  const auto opacity = number<double>(next_word(text));
  const bool coloured = colour.size() == 7 && colour[0] == '#';
  const auto rgb = coloured ? number<std::uint32_t>(colour.substr(1), 16) : std::nullopt;
  const bool in_range = opacity && *opacity >= 0 && *opacity <= kMostOpacity;  // false for a NaN
  if (!level || !rgb || !in_range || !next_word(text).empty()) return std::nullopt;
  const auto part = [&](int shift) { return static_cast<std::uint8_t>(*rgb >> shift & 0xFFU); };
  return TransferFunction::Point{
      .level = *level, .colour = {part(16), part(8), part(0)}, .opacity_per_mm = *opacity};
}

}  // namespace

TransferFunction::TransferFunction() : count_(3) {
  points_[0] = {.level = 0, .colour = {89, 31, 20}, .opacity_per_mm = 0};
  points_[1] = {.level = 60, .colour = {128, 79, 65}, .opacity_per_mm = 0};
  points_[2] = {.level = 255, .colour = {255, 235, 209}, .opacity_per_mm = 0.3};
}

Result<TransferFunction> TransferFunction::parse(std::string_view text) {
  constexpr std::size_t kMostText = 1024;
  const auto refused = [](const std::string& wrong) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("{}, expected 1 to {} points \"LEVEL #RRGGBB OPACITY\" separated by commas, levels "
                    "rising from 0 to 255, opacity 0 to {} per mm",
                    wrong, kMostPoints, kMostOpacity)};
  };
  if (text.size() > kMostText)
    return refused(fmt::format("the text is longer than {} characters", kMostText));
  TransferFunction made;
  made.points_ = {};
  made.count_ = 0;
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    more = comma != std::string_view::npos;
    const std::size_t place = made.count_ + 1;
    if (place > kMostPoints) return refused(fmt::format("there are more than {} points", kMostPoints));
    const auto read = point(text.substr(0, comma));
    if (!read) return refused(fmt::format("point {} cannot be read", place));
    if (place > 1 && read->level <= made.points_[made.count_ - 1].level) {
      return refused(fmt::format("the level of point {} does not rise", place));
    }
    made.points_[made.count_++] = *read;
    text.remove_prefix(more ? comma + 1 : text.size());
  }
  return made;
}

std::string TransferFunction::text() const {
  std::string text;
  for (const Point& each : points()) {
    text += fmt::format("{}{} #{:02x}{:02x}{:02x} {}", text.empty() ? "" : ", ", each.level, each.colour[0],
                        each.colour[1], each.colour[2], each.opacity_per_mm);
  }
  return text;
}

TransferFunction::Value TransferFunction::at(double level) const {
  std::size_t above = 0;
  while (above < count_ && points_[above].level <= level) ++above;
  const Point& high = points_[std::min(above, count_ - 1)];
  const Point& low = points_[above == 0 ? 0 : above - 1];
  const double share = high.level > low.level ? (level - low.level) / (high.level - low.level) : 0;
  Value value{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    value.colour[channel] = std::lerp(low.colour[channel], high.colour[channel], share) / 255.0;
  }
  value.opacity_per_mm = std::lerp(low.opacity_per_mm, high.opacity_per_mm, share);
  return value;
}

}  // namespace fanlight
