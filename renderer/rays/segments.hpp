// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "shaders/bindings.h"

namespace fanlight::ray_caster {

/// The segments of a tile's rays that have to be read (segment_skip.h).
class Segments {
 public:
  Segments(const std::uint32_t* mask, std::uint32_t shift) : mask_(mask), shift_(shift) {}

  bool none() const { return (mask_[0] | mask_[1] | mask_[2] | mask_[3]) == 0; }
  // The first sample from `index` on in a segment that has to be read, or with `inverse` in another one;
  // beyond the end of every ray if there is none.
  int first_sample_in(int index, bool inverse) const {
    const int segment = index >> shift_;
    for (int part = segment / 32; part < FANLIGHT_MAX_SEGMENTS / 32; ++part) {
      std::uint32_t bits = inverse ? ~mask_[part] : mask_[part];
      if (part == segment / 32) bits &= ~0U << static_cast<std::uint32_t>(segment % 32);
      if (bits != 0) return std::max(index, (32 * part + std::countr_zero(bits)) << shift_);
    }
    return 1 << 16;
  }

 private:
  const std::uint32_t* mask_;
  std::uint32_t shift_;
};

}  // namespace fanlight::ray_caster
