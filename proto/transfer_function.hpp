#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "proto/result.hpp"

namespace fanlight {

/// What an echo looks like in the composited volume: colour and opacity by grey level, linear between control
/// points and constant beyond the first and last. Plain memory, so that a scene travels without allocating.
class TransferFunction {
 public:
  static constexpr std::size_t kMostPoints = 16;

  struct Point {
    std::uint8_t level = 0;                ///< grey level of the echo
    std::array<std::uint8_t, 3> colour{};  ///< red, green, blue, as displayed (sRGB)
    double opacity_per_mm = 0;             ///< share of the light that a millimetre of it stops, 0 to 0.999

    bool operator==(const Point&) const = default;
  };

  /// Colour (0 to 1, as displayed) and opacity of a millimetre at one grey level.
  struct Value {
    std::array<double, 3> colour;
    double opacity_per_mm;
  };

  /// Dark red to bone, transparent up to 60.
  TransferFunction();

  /// "LEVEL #RRGGBB OPACITY" for each point, 1 to kMostPoints of them, separated by commas, levels rising:
  /// "60 #66231a 0, 255 #ffebd1 0.3". The error says what is wrong with which point.
  static Result<TransferFunction> parse(std::string_view text);

  /// What parse() reads back as the same.
  std::string text() const;

  std::span<const Point> points() const { return std::span(points_).first(count_); }

  /// At a grey level, which may be fractional, 0 to 255.
  Value at(double level) const;

  bool operator==(const TransferFunction&) const = default;

 private:
  std::array<Point, kMostPoints> points_{};  // those beyond count_ stay as made, so that == may compare all
  std::size_t count_ = 0;
};

}  // namespace fanlight
