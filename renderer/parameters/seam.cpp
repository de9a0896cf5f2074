// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/seam.hpp"

#include <algorithm>
#include <functional>

namespace fanlight {

void NewFrames::add(double angle_rad) {
  std::shift_right(angles_rad_.begin(), angles_rad_.end(), 1);
  angles_rad_.front() = angle_rad;
  kept_ = std::min(kept_ + 1, angles_rad_.size());
  ++count_;
}

bool NewFrames::turned() const {
  const auto angles = angles_rad();
  return !std::ranges::is_sorted(angles) && !std::ranges::is_sorted(angles, std::ranges::greater{});
}

double share_of_last_sweep(std::uint64_t newer, int seam_frames) {
  const double left = static_cast<double>(seam_frames) - static_cast<double>(newer);
  return std::max(left, 0.0) / (seam_frames + 1.0);
}

shaders::SeamParameters seam_parameters(const MapPlace& now, const Seam& seam, int seam_frames,
                                        std::uint64_t count_before) {
  constexpr std::size_t kY = 1;
  constexpr std::size_t kZ = 2;
  const PictureView& view = now.view;
  const auto component = [&](std::size_t axis) {
    return glm::vec3(view.right[axis], view.down[axis], view.forward[axis]);
  };
  const bool same_size = now.size == seam.earlier.place.size;
  shaders::SeamParameters to{.along = component(kY),
                             .across = component(kZ),
                             .along_at_0 = static_cast<float>(view.origin_mm[kY] + seam.motor_radius_mm),
                             .across_at_0 = static_cast<float>(view.origin_mm[kZ]),
                             .frames_per_rad = static_cast<float>(1 / seam.frame_step_rad),
                             .frames = 0,
                             .same_view = same_size && view == seam.earlier.place.view ? 1 : 0,
                             .angles = {},
                             .shares = {},
                             .shares_before = {}};
  // A turned view reads the map before between its pixels: without new frames too its share falls, so that it
  // is not blurred again and again.
  const std::uint64_t came = std::max<std::uint64_t>(seam.frames.count() - count_before, 1 - to.same_view);
  for (const double angle_rad : seam.frames.angles_rad()) {
    const auto newer = static_cast<std::uint64_t>(to.frames);
    const double share = share_of_last_sweep(newer, seam_frames);
    if (share <= 0) break;
    to.angles[newer] = static_cast<float>(angle_rad);
    to.shares[newer] = static_cast<float>(share);
    const bool was_old = newer < seam.frames.count() - count_before;
    to.shares_before[newer] =
        was_old ? 1.0F : static_cast<float>(share_of_last_sweep(newer - std::min(newer, came), seam_frames));
    ++to.frames;
  }
  return to;
}

}  // namespace fanlight
