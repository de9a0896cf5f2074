#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tests/accuracy/depth_truth.hpp"

namespace fanlight::test {

/// A surface shown within this of the true one is the true one.
inline constexpr double kFoundMm = 1.5;

/// Surfaces at which rays graze more steeply than this are a rim. There a blur of a fraction of a millimetre
/// across the surface becomes millimetres along the ray.
inline constexpr double kRimDeg = 75;
enum class Rim : std::uint8_t { kJudged, kApart };

/// How far the depths shown lie from the true ones, over the pixels of any number of pictures. Errors are
/// shown - true along the depth axis, mm: positive is too deep.
class DepthErrors {
 public:
  explicit DepthErrors(Rim rim) : rim_(rim) {}

  /// Judges the depth maps of one picture; negative depths are "no surface".
  void add(std::span<const float> shown_mm, std::span<const PixelTruth> truth, const PixelRays& rays,
           PictureSize size, const KnownSurface& surface);

  // Over the pixels with a true surface; one that is not shown is infinitely wrong.
  double median_mm() const { return magnitude_mm(0.5); }
  double magnitude_mm(double share) const;     ///< quantile of |error|
  double share_within(double error_mm) const;  ///< of |error|
  double share_found() const { return share_within(kFoundMm); }
  double share_missing() const;  ///< not shown
  double share_behind() const;   ///< shown more than kFoundMm behind the truth

  /// Of those that are shown.
  double signed_median_mm() const;

  /// Of the rays that meet the surface, or fluid alone: a surface is shown more than kFoundMm in front of the
  /// true one, or, where there is none, more than kFoundMm from any.
  double share_false() const;

  /// Of the rays that enter the fan in tissue and meet no surface: one is shown.
  double share_shown_in_tissue() const;

  /// Of the rim, where that is kept apart: found. It is then in no other figure but the next.
  double share_of_rim_found() const;

  // Over everything that can be judged at all: with the rim, and with the rays that enter the fan in tissue.
  double share_found_of_all() const;
  double share_false_of_all() const;

  std::uint64_t surfaces() const { return errors_mm_.size(); }

 private:
  void add_surface(double error_mm, double incidence_deg);

  Rim rim_;
  std::vector<double> errors_mm_;  // of every pixel with a true surface; HUGE_VAL where it is not shown
  std::uint64_t fluid_ = 0;        // rays through fluid alone
  std::uint64_t false_in_fluid_ = 0;
  std::uint64_t tissue_first_ = 0;
  std::uint64_t shown_in_tissue_ = 0;
  std::uint64_t on_rim_ = 0;
  std::uint64_t found_on_rim_ = 0;
  std::uint64_t false_on_rim_ = 0;
};

}  // namespace fanlight::test
