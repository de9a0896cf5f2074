// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace fanlight {

/// Which pixels of Cartesian frames are "not scanned" (FanGeometry::zero_is_unscanned).
enum class Unscanned : std::uint8_t {
  kDetect,  ///< of a volume on a grid, its padding (find_padding()); of a recording, what lies outside the
            ///< sector that is seen in it (see_sector())
  kZero,    ///< of frames, those of grey level 0; of a volume, what has the value of its border up to it
  kNone,
};

/// Their names in files, by Unscanned.
inline constexpr std::array<std::string_view, 3> kUnscannedNames = {"detect", "zero", "none"};

}  // namespace fanlight
