// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace fanlight {

/// What can look wrong in a sweep that was assembled all the same.
enum class SweepWarning : std::uint8_t {
  kCopies,      ///< frames are exact copies of their neighbours, at other angles
  kBlank,       ///< frames have one grey level throughout
  kOutOfOrder,  ///< frames resemble distant frames much more than their neighbours
  kJump,        ///< the picture changes abruptly between two neighbours
  kSparse,      ///< neighbours are far apart
  kMirrored,    ///< the sweep resembles the mirror image of the one before
  kRings,       ///< all lines of all frames are alike
};
inline constexpr std::size_t kSweepWarnings = 7;

struct SweepWarningText {
  std::string_view name;      ///< for programs
  std::string_view sentence;  ///< for people
};

/// In the order of SweepWarning.
inline constexpr std::array<SweepWarningText, kSweepWarnings> kSweepWarningTexts = {{
    {"copies", "Frames are exact copies of their neighbours: the picture of the probe may be frozen."},
    {"blank", "Frames have a single grey level: the probe may send no echoes."},
    {"out-of-order", "Frames resemble distant frames more than their neighbours: they may be out of order."},
    {"jump",
     "The picture jumps between two neighbouring frames: the motor may have slipped, or the probe or the "
     "body "
     "has moved."},
    {"sparse", "Neighbouring frames are more than 5 deg apart: the surface between them is interpolated."},
    {"mirrored",
     "The sweep looks like the mirror image of the one before: the angles of every second sweep may be "
     "reversed."},
    {"rings", "All lines show the same echoes: the probe may be in air."},
}};

/// Numbers of volumes, in the order of SweepWarning.
using WarnedVolumes = std::array<std::uint64_t, kSweepWarnings>;

/// A set of them.
class SweepWarnings {
 public:
  constexpr void add(SweepWarning warning) { bits_ |= bit(warning); }
  constexpr bool has(SweepWarning warning) const { return (bits_ & bit(warning)) != 0; }
  constexpr bool empty() const { return bits_ == 0; }

  /// Calls `use` with each one's text, in the order of SweepWarning.
  template <typename Use>
  void for_each(Use use) const {
    for (std::size_t i = 0; i < kSweepWarnings; ++i)
      if (has(static_cast<SweepWarning>(i))) use(kSweepWarningTexts[i]);
  }

  bool operator==(const SweepWarnings&) const = default;

 private:
  static constexpr std::uint8_t bit(SweepWarning warning) {
    return static_cast<std::uint8_t>(1U << static_cast<unsigned>(warning));
  }

  std::uint8_t bits_ = 0;
};

}  // namespace fanlight
