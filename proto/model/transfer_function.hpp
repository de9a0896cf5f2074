// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// Colour and opacity by grey level in the composited volume, linear between control points and constant
/// beyond the first and last. Fixed size, so that a scene can be copied without allocation.
class TransferFunction {
 public:
  static constexpr std::size_t kMostPoints = 16;

  struct Point {
    std::uint8_t level = 0;                ///< grey level of the echo
    std::array<std::uint8_t, 3> colour{};  ///< red, green, blue, as displayed (sRGB)
    double opacity_per_mm = 0;             ///< fraction of light absorbed per millimetre, 0 to 0.999

    bool operator==(const Point&) const = default;
  };

  /// Colour (0 to 1, sRGB) and opacity per millimetre at one grey level.
  struct Value {
    std::array<double, 3> colour;
    double opacity_per_mm;
  };

  /// Dark red to bone white, transparent up to level 60.
  TransferFunction();

  /// Parses "LEVEL #RRGGBB OPACITY" for each point, 1 to kMostPoints of them, separated by commas, levels
  /// ascending: "60 #66231a 0, 255 #ffebd1 0.3". The error names the point and what is wrong with it.
  static Result<TransferFunction> parse(std::string_view text);

  /// Text from which parse() gives an equal function.
  std::string text() const;

  std::span<const Point> points() const { return std::span(points_).first(count_); }

  /// At a grey level from 0 to 255, which may be fractional.
  Value at(double level) const;

  bool operator==(const TransferFunction&) const = default;

 private:
  std::array<Point, kMostPoints>
      points_{};  // points beyond count_ stay default constructed, so that == may compare all
  std::size_t count_ = 0;
};

}  // namespace fanlight
