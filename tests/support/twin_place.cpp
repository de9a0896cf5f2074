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

/// The echoes about an edge, from the fluid towards the tissue.
class EdgeEchoes {
 public:
  EdgeEchoes(const Scene::Detector& detector, const SampleEcho& value, double position)
      : value_(value), half_(detector.window / 2), window_(detector.window) {
    const int oldest = static_cast<int>(std::ceil(position + half_ - 1)) - (window_ - 1);
    const bool rises = sum_of(oldest + half_, half_) >= sum_of(oldest, half_);
    inwards_ = detector.sign == EdgeSign::kEither ? rises : detector.sign == EdgeSign::kDarkToBright;
    start_ = inwards_ ? oldest : oldest + window_ - 1;
  }

  /// Means of this many samples, one each stride(), from the start towards the tissue.
  std::vector<double> means(int count) const {
    std::vector<double> of;
    for (int number = 0; number + stride() * (count - 1) < window_ + half_; number += stride()) {
      double sum = 0;
      for (int each = 0; each < count; ++each) {
        const int from_start = number + stride() * each;
        sum += value_(inwards_ ? start_ + from_start : start_ - from_start);
      }
      of.push_back(sum / count);
    }
    return of;
  }

  int stride() const { return half_ < 8 ? 1 : 2; }
  int mean() const { return half_ < 8 ? half_ : 4; }
  int in_window() const { return (window_ + stride() - 1) / stride(); }
  double tissue() const { return std::ranges::max(means(mean())); }
  double fluid() const {
    const std::vector<double> wide = means(mean());
    return *std::min_element(wide.begin(), wide.begin() + (in_window() - mean() + 1));
  }
  double place_of(double values) const { return start_ + (inwards_ ? values : -values); }

 private:
  double sum_of(int first, int count) const {
    double sum = 0;
    for (int at = first; at < first + count; ++at) sum += value_(at);
    return sum;
  }

  const SampleEcho& value_;
  int half_;
  int window_;
  bool inwards_ = true;
  int start_ = 0;
};

}  // namespace

std::optional<double> twin_certainty(const Scene::Detector& detector, const SampleEcho& value,
                                     double position) {
  const EdgeEchoes echoes(detector, value, position);
  const double contrast = echoes.tissue() - echoes.fluid();
  const double least_contrast = detector.least_contrast / 255;
  if (contrast < least_contrast) return std::nullopt;
  const double certain_beyond = std::min(least_contrast, 30 / 255.0);
  return certain_beyond > 0 ? std::min((contrast - least_contrast) / certain_beyond, 1.0) : 1;
}

std::optional<TwinPlace> twin_place_by_level(const Scene::Detector& detector, const SampleEcho& value,
                                             double spacing_mm, double position) {
  const EdgeEchoes echoes(detector, value, position);
  const double least_tissue = detector.least_tissue / 255;
  const std::vector<double> narrow = echoes.means((echoes.mean() + 1) / 2);
  if (*std::max_element(narrow.begin() + echoes.in_window() / 2, narrow.end()) < least_tissue)
    return std::nullopt;
  const auto certainty = twin_certainty(detector, value, position);
  if (!certainty) return std::nullopt;
  const double tissue = echoes.tissue();
  const double fluid = echoes.fluid();
  const std::vector<double> values = echoes.means(1);
  const double peak = std::ranges::max(narrow);
  const double middle = (fluid + peak) / 2;
  const bool is_sheet =
      std::ranges::count_if(values, [=](double each) { return each > middle; }) <= echoes.mean();
  const double front = std::clamp(peak - detector.sheet_below / 255, middle, std::lerp(fluid, peak, 0.92));
  const double level = std::max(is_sheet ? front : std::lerp(fluid, tissue, detector.rise), least_tissue);
  const double foot = std::lerp(fluid, tissue, std::clamp(1 - 2.4 * (1 - detector.rise), 0.25, 0.5));
  const auto rise = rise_through(values, std::min(foot, level), level);
  if (!rise) return TwinPlace{position, *certainty};
  const int stride = echoes.stride();
  const double long_mm = stride * (rise->level - rise->foot) * spacing_mm - 0.5;
  const double most_mm = detector.window / 2.0 * spacing_mm;
  const double behind_mm = std::min(detector.reach * std::max(long_mm, 0.0), most_mm);
  return TwinPlace{echoes.place_of(stride * rise->level + behind_mm / spacing_mm), *certainty};
}

}  // namespace fanlight::test
