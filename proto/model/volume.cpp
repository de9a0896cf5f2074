// SPDX-License-Identifier: Apache-2.0
#include "proto/model/volume.hpp"

#include <algorithm>

namespace fanlight {

bool Volume::copy_from(const Volume& other) {
  const std::uint64_t bytes = other.geometry_.frame_bytes() * other.stamp_.frames;
  if (other.stamp_.frames > frame_capacity_ || bytes > capacity_bytes_) return false;
  geometry_ = other.geometry_;
  stamp_ = other.stamp_;
  std::copy_n(other.pixels_.get(), bytes, pixels_.get());
  std::copy_n(other.angles_rad_.begin(), stamp_.frames, angles_rad_.begin());
  std::copy_n(other.commit_numbers_.begin(), stamp_.frames, commit_numbers_.begin());
  std::copy_n(other.by_angle_.begin(), stamp_.frames, by_angle_.begin());
  return true;
}

}  // namespace fanlight
