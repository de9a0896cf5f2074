// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

/// Pose of an image in space: a 4 x 4 matrix in row order from pixels (column, row, 0) to mm.
using ImagePose = std::array<double, 16>;

/// A fan that poses were fitted to: all images turn about one axis, parallel to their rows.
struct FanFit {
  std::vector<double> angles_rad;  ///< of each image, about the axis; 0 in the middle of the range
  double axis_mm = 0;              ///< from row 0 down to the axis; negative: behind the probe
  double residual_mm = 0;          ///< root mean square distance of the images' own axes from their mean
  double slide_mm = 0;             ///< root mean square shift along the axis
  double turn_deg = 0;             ///< root mean square angle of the images' rows to the axis

  // Where the fan is, in the frame of reference of the poses.
  std::array<double, 3> axis{};      ///< unit vector, along the rows
  std::array<double, 3> forward{};   ///< unit vector, from the axis into the body at angle 0
  std::array<double, 3> pivot_mm{};  ///< the mean of the images' own points on the axis
};

/// Where a further image lies in a fan.
struct PlaceInFan {
  double angle_rad = 0;
  double miss_mm = 0;   ///< distance of its own axis from the fan's
  double slide_mm = 0;  ///< along the axis
  double turn_deg = 0;  ///< angle of its rows to the axis
};

/// The best fan through the poses. With the images' unit vectors x (along rows) and y (down), origins o and
/// an axis at distance a below row 0, every point o + a y is the same for a fan; a is chosen for the least
/// sum of squares of their distances from the mean, which is linear: a = -cov(y, o) / cov(y, y). The angle of
/// an image is that of its y about the mean x. `centre_column`: the origins are taken there, so that an image
/// that turns out of the fan moves its axis point little. Error, kBadInput: fewer than 3 poses, or one that
/// is no pose.
Result<FanFit> fit_fan(std::span<const ImagePose> poses, double centre_column);

/// nullopt: no pose. Allocates nothing.
std::optional<PlaceInFan> place_in_fan(const FanFit& fit, const ImagePose& pose, double centre_column);

/// Whether an image that was not among those of the fit lies in its fan, within the limits of why_no_fan().
bool lies_in_fan(const PlaceInFan& place);

/// Why these poses are no fan that may be shown as one: the sentence says how far they are from it. Empty:
/// they are.
std::string why_no_fan(const FanFit& fit);

}  // namespace fanlight
