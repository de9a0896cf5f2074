// SPDX-License-Identifier: Apache-2.0
#include "tests/accuracy/depth_errors.hpp"

#include <algorithm>
#include <cmath>

namespace fanlight::test {

namespace {

/// The quantile, `share` from 0 to 1; NaN of no values.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::ranges::nth_element(values, place);
  return *place;
}

double share_of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? NAN : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

void DepthErrors::add(std::span<const float> shown_mm, std::span<const PixelTruth> truth,
                      const PixelRays& rays, PictureSize size, const KnownSurface& surface) {
  for (std::size_t pixel = 0; pixel < truth.size(); ++pixel) {
    const bool shown = shown_mm[pixel] >= 0;
    const double depth_mm = shown_mm[pixel];
    switch (truth[pixel].meets) {
      case Meets::kSurface:
        add_surface(shown ? depth_mm - truth[pixel].depth_mm : HUGE_VAL, truth[pixel].incidence_deg);
        break;
      case Meets::kFluid: {
        const PixelRay ray = rays.ray(static_cast<std::uint32_t>(pixel % size.width),
                                      static_cast<std::uint32_t>(pixel / size.width));
        ++fluid_;
        false_in_fluid_ += shown && std::abs(surface.below_mm(ray.at(depth_mm))) > kFoundMm ? 1 : 0;
        break;
      }
      case Meets::kTissueFirst:
        ++tissue_first_;
        shown_in_tissue_ += shown ? 1 : 0;
        break;
      case Meets::kNothing:
      case Meets::kBorder:
        break;
    }
  }
}

void DepthErrors::add_surface(double error_mm, double incidence_deg) {
  if (rim_ == Rim::kJudged || incidence_deg <= kRimDeg) {
    errors_mm_.push_back(error_mm);
    return;
  }
  ++on_rim_;
  found_on_rim_ += std::abs(error_mm) <= kFoundMm ? 1 : 0;
  false_on_rim_ += error_mm < -kFoundMm ? 1 : 0;
}

double DepthErrors::share_of_rim_found() const {
  return share_of(found_on_rim_, on_rim_);
}

double DepthErrors::share_found_of_all() const {
  const auto found =
      std::ranges::count_if(errors_mm_, [](double error) { return std::abs(error) <= kFoundMm; });
  return share_of(static_cast<std::uint64_t>(found) + found_on_rim_, errors_mm_.size() + on_rim_);
}

double DepthErrors::share_false_of_all() const {
  const auto in_front = std::ranges::count_if(errors_mm_, [](double error) { return error < -kFoundMm; });
  return share_of(static_cast<std::uint64_t>(in_front) + false_on_rim_ + false_in_fluid_ + shown_in_tissue_,
                  errors_mm_.size() + on_rim_ + fluid_ + tissue_first_);
}

double DepthErrors::magnitude_mm(double share) const {
  std::vector<double> magnitudes;
  for (const double error_mm : errors_mm_) magnitudes.push_back(std::abs(error_mm));
  return quantile(std::move(magnitudes), share);
}

double DepthErrors::share_within(double error_mm) const {
  const auto within =
      std::ranges::count_if(errors_mm_, [&](double error) { return std::abs(error) <= error_mm; });
  return share_of(static_cast<std::uint64_t>(within), errors_mm_.size());
}

double DepthErrors::share_missing() const {
  return share_of(static_cast<std::uint64_t>(std::ranges::count(errors_mm_, HUGE_VAL)), errors_mm_.size());
}

double DepthErrors::share_behind() const {
  const auto behind =
      std::ranges::count_if(errors_mm_, [](double error) { return error > kFoundMm && error < HUGE_VAL; });
  return share_of(static_cast<std::uint64_t>(behind), errors_mm_.size());
}

double DepthErrors::signed_median_mm() const {
  std::vector<double> shown;
  std::ranges::copy_if(errors_mm_, std::back_inserter(shown), [](double error) { return error < HUGE_VAL; });
  return quantile(std::move(shown), 0.5);
}

double DepthErrors::share_false() const {
  const auto in_front = std::ranges::count_if(errors_mm_, [](double error) { return error < -kFoundMm; });
  return share_of(static_cast<std::uint64_t>(in_front) + false_in_fluid_, errors_mm_.size() + fluid_);
}

double DepthErrors::share_shown_in_tissue() const {
  return share_of(shown_in_tissue_, tissue_first_);
}

}  // namespace fanlight::test
