#include "renderer/fan_table.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight {

namespace {

// Linear interpolation of rho over a texel of h errs by h^2 / 8R: 1 um at 30 mm from the sweep axis.
constexpr double kFinestTexelMm = 0.5;
constexpr double kMostTexels = 1024;
constexpr int kMarginTexels = 2;

FanTable::Box box_of(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad) {
  // The axis is the end of the fan: rows behind it show nothing.
  const double nearest_mm =
      std::max(-geometry.face_row * geometry.pixel_height_mm, -geometry.motor_radius_mm);
  const double straight_rad = std::clamp(0.0, first_angle_rad, last_angle_rad);
  FanTable::Box box{.lowest = {geometry.left_mm(), HUGE_VAL, HUGE_VAL},
                    .highest = {geometry.right_mm(), -HUGE_VAL, -HUGE_VAL}};
  // y and z are monotonic in rho, and y's only extremum over the angle is straight ahead.
  for (const double angle_rad : {first_angle_rad, straight_rad, last_angle_rad}) {
    for (const double depth_mm : {nearest_mm, geometry.depth_mm()}) {
      const Point corner = geometry.point(0, {.angle_rad = angle_rad, .depth_mm = depth_mm});
      box.lowest.y_mm = std::min(box.lowest.y_mm, corner.y_mm);
      box.lowest.z_mm = std::min(box.lowest.z_mm, corner.z_mm);
      box.highest.y_mm = std::max(box.highest.y_mm, corner.y_mm);
      box.highest.z_mm = std::max(box.highest.z_mm, corner.z_mm);
    }
  }
  return box;
}

}  // namespace

FanTable::FanTable(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad,
                   std::uint32_t frame_capacity)
    : box_(box_of(geometry, first_angle_rad, last_angle_rad)), placed_angles_(frame_capacity) {
  const double y_mm = box_.highest.y_mm - box_.lowest.y_mm;
  const double z_mm = box_.highest.z_mm - box_.lowest.z_mm;
  texel_mm_ = std::max(kFinestTexelMm, std::max(y_mm, z_mm) / (kMostTexels - 1 - 2 * kMarginTexels));
  height_ = static_cast<std::uint32_t>(std::ceil(y_mm / texel_mm_)) + 1 + 2 * kMarginTexels;
  width_ = static_cast<std::uint32_t>(std::ceil(z_mm / texel_mm_)) + 1 + 2 * kMarginTexels;
  y_first_mm_ = box_.lowest.y_mm - kMarginTexels * texel_mm_;
  z_first_mm_ = box_.lowest.z_mm - kMarginTexels * texel_mm_;

  angles_.reserve(std::size_t{width_} * height_);
  texels_.reserve(std::size_t{width_} * height_);
  for (std::uint32_t row = 0; row < height_; ++row) {
    for (std::uint32_t column = 0; column < width_; ++column) {
      const FanCoordinate at =
          geometry.fan_coordinate(y_first_mm_ + row * texel_mm_, z_first_mm_ + column * texel_mm_);
      angles_.push_back(at.angle_rad);
      texels_.emplace_back(static_cast<float>(at.depth_mm), 0.0F);
    }
  }
}

FanTable::Axis FanTable::axis(double first_mm, std::uint32_t texels) const {
  // Texel 0's centre is at texture coordinate 0.5 / texels.
  const double scale = 1.0 / (texel_mm_ * texels);
  return {.scale = scale, .offset = 0.5 / texels - first_mm * scale};
}

bool FanTable::place(const Volume& volume) {
  const auto order = volume.by_angle();
  const auto angle = [&](std::size_t place) { return volume.angles_rad()[order[place]]; };
  bool changed = placed_frames_ != order.size();
  for (std::size_t place = 0; place < order.size(); ++place) {
    changed |= placed_angles_[place] != angle(place);
    placed_angles_[place] = angle(place);
  }
  placed_frames_ = static_cast<std::uint32_t>(order.size());
  if (!changed) return false;

  const std::size_t last = order.size() - 1;
  const double mean_step_rad = (angle(last) - angle(0)) / static_cast<double>(last);
  for (std::uint32_t row = 0; row < height_; ++row) {
    // Along z the angle only grows, so the frame below it is found by walking on.
    std::size_t below = 0;
    for (std::size_t texel = std::size_t{row} * width_; texel < std::size_t{row + 1} * width_; ++texel) {
      const double at_rad = angles_[texel];
      while (below < last && placed_angles_[below + 1] <= at_rad) ++below;
      double coordinate = 0;
      if (at_rad < placed_angles_[0]) {
        coordinate = (at_rad - placed_angles_[0]) / mean_step_rad;
      } else if (below == last) {
        coordinate = static_cast<double>(last) + (at_rad - placed_angles_[last]) / mean_step_rad;
      } else {
        // Frames at one angle are passed over by the walk, so this step is never 0 wide.
        const double step_rad = placed_angles_[below + 1] - placed_angles_[below];
        coordinate = static_cast<double>(below) + (at_rad - placed_angles_[below]) / step_rad;
      }
      texels_[texel].y = static_cast<float>(coordinate);
    }
  }
  return true;
}

}  // namespace fanlight
