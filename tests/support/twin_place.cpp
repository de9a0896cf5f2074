// SPDX-License-Identifier: Apache-2.0
#include "tests/support/twin_place.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace fanlight::test {

namespace {

/// Where values first rise past a level, and where they last rose past the foot before; the same without one.
struct Rise {
  double foot = 0;
  double level = 0;
};
std::optional<Rise> rise_through(const std::vector<double>& values, double foot_level, double level) {
  std::optional<double> foot;
  for (std::size_t next = 1; next < values.size(); ++next) {
    const double before = values[next - 1];
    const double after = values[next];
    const auto place_of = [&](double wanted) {
      return static_cast<double>(next - 1) +
             std::clamp((wanted - before) / std::max(after - before, 1e-6), 0.0, 1.0);
    };
    if (before < foot_level && after >= foot_level) foot = place_of(foot_level);
    if (before < level && after >= level) return Rise{foot.value_or(place_of(level)), place_of(level)};
  }
  return std::nullopt;
}

}  // namespace

std::optional<TwinPlace> twin_place_by_level(const Scene::Detector& detector, const SampleEcho& value,
                                             double spacing_mm, double position) {
  const int window = detector.window;
  const int half = window / 2;
  const int oldest = static_cast<int>(std::ceil(position + half - 1)) - (window - 1);
  const auto sum_of = [&](int first, int count) {
    double sum = 0;
    for (int at = first; at < first + count; ++at) sum += value(at);
    return sum;
  };
  const bool rises = sum_of(oldest + half, half) >= sum_of(oldest, half);
  const bool inwards = detector.sign == EdgeSign::kEither ? rises : detector.sign == EdgeSign::kDarkToBright;
  const int start = inwards ? oldest : oldest + window - 1;
  // Means of this many samples, one each `stride`, from the start towards the tissue.
  const auto means = [&](int count, int stride) {
    std::vector<double> of;
    for (int number = 0; number + stride * (count - 1) < window + half; number += stride) {
      double sum = 0;
      for (int each = 0; each < count; ++each) {
        const int from_start = number + stride * each;
        sum += value(inwards ? start + from_start : start - from_start);
      }
      of.push_back(sum / count);
    }
    return of;
  };
  const int stride = half < 8 ? 1 : 2;
  const int mean = half < 8 ? half : 4;
  const std::vector<double> wide = means(mean, stride);
  const double least_tissue = detector.least_tissue / 255;
  const int in_window = (window + stride - 1) / stride;
  const std::vector<double> narrow = means((mean + 1) / 2, stride);
  if (*std::max_element(narrow.begin() + in_window / 2, narrow.end()) < least_tissue) return std::nullopt;
  const double tissue = *std::ranges::max_element(wide);
  const double fluid = *std::min_element(wide.begin(), wide.begin() + (in_window - mean + 1));
  const double least_contrast = detector.least_contrast / 255;
  if (tissue - fluid < least_contrast) return std::nullopt;
  const double sure = least_contrast > 0 ? std::min((tissue - fluid) / least_contrast - 1, 1.0) : 1;
  const std::vector<double> values = means(1, stride);
  const double peak = *std::ranges::max_element(narrow);
  const double middle = (fluid + peak) / 2;
  const bool is_sheet = std::ranges::count_if(values, [=](double each) { return each > middle; }) <= mean;
  const double front = std::clamp(peak - detector.sheet_below / 255, middle, std::lerp(fluid, peak, 0.92));
  const double level = std::max(is_sheet ? front : std::lerp(fluid, tissue, detector.rise), least_tissue);
  const auto rise = rise_through(values, std::min(std::lerp(fluid, tissue, 0.35), level), level);
  if (!rise) return TwinPlace{position, sure};
  const double long_mm = stride * (rise->level - rise->foot) * spacing_mm - 0.5;
  const double behind_mm = std::min(detector.reach * std::max(long_mm, 0.0), half * spacing_mm);
  const double found = stride * rise->level + behind_mm / spacing_mm;
  return TwinPlace{start + (inwards ? found : -found), sure};
}

}  // namespace fanlight::test
