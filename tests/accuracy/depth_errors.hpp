// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tests/accuracy/depth_truth.hpp"

namespace fanlight::test {

/// A rendered surface within this distance of the true one counts as found.
inline constexpr double kFoundMm = 1.5;

/// Surfaces whose normal is at more than this angle to the ray form the rim. There a blur of a fraction of a
/// millimetre across the surface becomes millimetres along the ray. kJudged: the rim counts like the rest.
/// kApart: it is counted separately.
inline constexpr double kRimDeg = 75;
enum class Rim : std::uint8_t { kJudged, kApart };

/// Errors of rendered depths, over the pixels of any number of pictures. An error is rendered depth - true
/// depth, mm: positive is too deep. All shares are 0 to 1; without a pixel to judge, a figure is NaN.
class DepthErrors {
 public:
  explicit DepthErrors(Rim rim) : rim_(rim) {}

  /// Adds the depth map of one picture, row by row; negative depths are "no surface".
  void add(std::span<const float> shown_mm, std::span<const PixelTruth> truth, const PixelRays& rays,
           PictureSize size, const KnownSurface& surface);

  // Over the pixels with a true surface. A surface that is not rendered has an infinite error.
  double median_mm() const { return magnitude_mm(0.5); }
  double magnitude_mm(double share) const;     ///< quantile of |error|
  double share_within(double error_mm) const;  ///< of |error|
  double share_found() const { return share_within(kFoundMm); }
  double share_missing() const;  ///< not rendered
  double share_behind() const;   ///< rendered more than kFoundMm behind the true depth

  /// Over the rendered surfaces.
  double signed_median_mm() const;

  /// Over the rays that meet the surface, or fluid only: a surface is rendered more than kFoundMm in front of
  /// the true one, or, on a ray through fluid, more than kFoundMm from any surface.
  double share_false() const;

  /// Over the rays that enter the fan in tissue and meet no surface: a surface is rendered.
  double share_shown_in_tissue() const;

  /// With Rim::kApart: share of the rim that is found. The rim is then only in this figure and the
  /// ..._of_all() figures.
  double share_of_rim_found() const;

  // Over everything: with the rim, and with the rays that enter the fan in tissue.
  double share_found_of_all() const;
  double share_false_of_all() const;

  std::uint64_t surfaces() const { return errors_mm_.size(); }

 private:
  void add_surface(double error_mm, double incidence_deg);

  Rim rim_;
  std::vector<double> errors_mm_;  // of each pixel with a true surface; HUGE_VAL: not rendered
  std::uint64_t fluid_ = 0;        // rays through fluid only
  std::uint64_t false_in_fluid_ = 0;
  std::uint64_t tissue_first_ = 0;
  std::uint64_t shown_in_tissue_ = 0;
  std::uint64_t on_rim_ = 0;
  std::uint64_t found_on_rim_ = 0;
  std::uint64_t false_on_rim_ = 0;
};

}  // namespace fanlight::test
