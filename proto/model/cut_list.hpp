// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// What the scalpel has cut away: shapes in the transducer frame, in mm, in the order of the cuts. Fixed
/// size, so that a scene can be copied without allocation.
class CutList {
 public:
  static constexpr std::size_t kMostCuts = 24;
  static constexpr std::size_t kMostNumbers = 1536;  ///< coordinates of all shapes
  static constexpr std::size_t kMostText = 32768;    ///< characters

  enum class Kind : std::uint8_t {
    kInside,   ///< what lies inside a lasso
    kOutside,  ///< what lies outside a lasso
    kBalls,
  };

  using Vector = std::array<float, 3>;

  /// One shape. Its coordinates are numbers(): of a lasso x and y of each corner in its plane, of balls x, y
  /// and z of each centre.
  struct Cut {
    Kind kind = Kind::kInside;
    // A lasso, drawn in a plane. Lines through it, along the normal or from the eye, are cut.
    Vector origin{};       ///< of the plane
    Vector right{};        ///< unit vectors in the plane, at right angles
    Vector up{};           ///< the normal, away from the viewer: up x right
    float eye_mm = 0;      ///< distance of the eye before the plane; 0: lines along the normal
    float nearest_mm = 0;  ///< depths below the plane, along the normal, between which is cut
    float farthest_mm = 0;
    float radius_mm = 0;      ///< of balls
    std::uint32_t first = 0;  ///< index of its first number
    std::uint32_t count = 0;

    bool operator==(const Cut&) const = default;
  };

  /// Parses cuts that are separated by semicolons; an empty text has none. Each is one of
  ///   inside NEAREST FARTHEST from X Y Z right X Y Z up X Y Z eye MM outline X Y X Y X Y ...
  ///   outside ... (the same)
  ///   balls RADIUS at X Y Z ...
  /// The error names the cut and what was expected.
  static Result<CutList> parse(std::string_view text);

  /// Text from which parse() gives an equal list.
  std::string text() const;

  std::span<const Cut> cuts() const { return std::span(cuts_).first(cut_count_); }
  std::span<const float> numbers(const Cut& cut) const {
    return std::span(numbers_).subspan(cut.first, cut.count);
  }
  bool empty() const { return cut_count_ == 0; }

  /// Whether this list is `earlier` with further cuts, or with further balls in its last cut, or equal to it.
  bool continues(const CutList& earlier) const;

  bool operator==(const CutList& other) const {
    return cut_count_ == other.cut_count_ && number_count_ == other.number_count_ && continues(other);
  }

 private:
  Result<void> add(std::string_view text);

  std::array<Cut, kMostCuts> cuts_{};
  std::array<float, kMostNumbers> numbers_{};
  std::uint32_t cut_count_ = 0;
  std::uint32_t number_count_ = 0;
};

}  // namespace fanlight
