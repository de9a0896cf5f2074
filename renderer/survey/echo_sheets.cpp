// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/echo_sheets.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

namespace fanlight {

namespace {

// A sheet may rise by so much from one profile to the next.
constexpr int kMostRiseCells = 3;
constexpr std::size_t kPeaks = 2;  // candidates in a profile: its largest steps

double median(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The largest steps of each profile, and which of them hang together.
class Sheets {
 public:
  Sheets(const VolumeProfiles& profiles, const EchoSteps& steps, float least_step) : least_step_(least_step) {
    first_of_.reserve(profiles.profiles() + 1);
    for (std::uint32_t profile = 0; profile < profiles.profiles(); ++profile) {
      first_of_.push_back(peaks_.size());
      add_peaks(profile, steps);
    }
    first_of_.push_back(peaks_.size());
    parents_.resize(peaks_.size());
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    for (std::uint32_t profile = 0; profile < profiles.profiles(); ++profile) {
      if ((profile + 1) % profiles.across() != 0) join(profile, profile + 1);
      if (profile + profiles.across() < profiles.profiles()) join(profile, profile + profiles.across());
    }
  }

  /// The `most` sheets with the largest sums of steps, the largest first.
  std::vector<Sheet> strongest(std::size_t most) {
    std::vector<double> sums(peaks_.size(), 0.0);
    for (std::size_t i = 0; i < peaks_.size(); ++i) sums[root(i)] += peaks_[i].step;
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < peaks_.size(); ++i) {
      if (root(i) == i) roots.push_back(i);
    }
    most = std::min(most, roots.size());
    std::ranges::partial_sort(roots, roots.begin() + static_cast<std::ptrdiff_t>(most), std::greater(),
                              [&](std::size_t each) { return sums[each]; });
    std::vector<Sheet> sheets;
    for (std::size_t i = 0; i < most; ++i) sheets.push_back(sheet_of(roots[i]));
    return sheets;
  }

 private:
  /// Of each profile its largest step.
  Sheet sheet_of(std::size_t wanted) {
    Sheet sheet;
    for (std::size_t i = 0; i < peaks_.size(); ++i) {
      if (root(i) != wanted) continue;
      if (!sheet.empty() && sheet.back().profile == peaks_[i].profile) {
        if (peaks_[i].step > sheet.back().step) sheet.back() = peaks_[i];
      } else {
        sheet.push_back(peaks_[i]);
      }
    }
    return sheet;
  }

  void add_peaks(std::uint32_t profile, const EchoSteps& steps) {
    std::vector<SheetPoint> found;
    for (int cell = steps.first_peak(profile, 0, least_step_); cell >= 0;
         cell = steps.first_peak(profile, cell + 1, least_step_)) {
      found.push_back({profile, cell, steps.at(profile, static_cast<std::uint32_t>(cell))});
    }
    if (found.size() > kPeaks) {
      std::ranges::nth_element(found, found.begin() + kPeaks, std::greater(), &SheetPoint::step);
      found.resize(kPeaks);
      std::ranges::sort(found, {}, &SheetPoint::cell);
    }
    peaks_.insert(peaks_.end(), found.begin(), found.end());
  }

  void join(std::uint32_t a, std::uint32_t b) {
    for (std::size_t i = first_of_[a]; i < first_of_[a + 1]; ++i) {
      for (std::size_t j = first_of_[b]; j < first_of_[b + 1]; ++j) {
        if (std::abs(peaks_[i].cell - peaks_[j].cell) <= kMostRiseCells) parents_[root(i)] = root(j);
      }
    }
  }

  std::size_t root(std::size_t peak) {
    while (parents_[peak] != peak) {
      parents_[peak] = parents_[parents_[peak]];
      peak = parents_[peak];
    }
    return peak;
  }

  float least_step_;
  std::vector<SheetPoint> peaks_;      // in order of profiles, then of cells
  std::vector<std::size_t> first_of_;  // index of each profile's first peak, and the end
  std::vector<std::size_t> parents_;   // union-find
};

}  // namespace

std::vector<CellRange> all_cells(const VolumeProfiles& profiles) {
  return std::vector<CellRange>(profiles.profiles(), {0, static_cast<int>(profiles.cells())});
}

EchoSteps::EchoSteps(const VolumeProfiles& profiles, std::vector<CellRange> ranges, EdgeSign sign)
    : profiles_(profiles),
      ranges_(std::move(ranges)),
      sign_(sign),
      window_(std::max(1, static_cast<int>(std::lround(kSurveyWindowMm / profiles.cell_mm())))),
      steps_(std::size_t{profiles.profiles()} * profiles.cells(), 0.0F) {
  for (std::uint32_t profile = 0; profile < profiles.profiles(); ++profile) fill(profile);
}

int EchoSteps::first_peak(std::uint32_t profile, int from, float least) const {
  const CellRange range = ranges_[profile];
  const int end = std::min(range.end, static_cast<int>(profiles_.cells()) - 1);
  for (int cell = std::max({from, 1, range.first}); cell < end; ++cell) {
    const auto here = static_cast<std::uint32_t>(cell);
    const float step = at(profile, here);
    if (step >= least && step >= at(profile, here - 1) && step > at(profile, here + 1)) return cell;
  }
  return -1;
}

double EchoSteps::clutter() const {
  return median(sizes_);
}

void EchoSteps::fill(std::uint32_t profile) {
  const int cells = static_cast<int>(profiles_.cells());
  for (int cell = window_; cell + window_ <= cells; ++cell) {
    float before = 0;
    float behind = 0;
    bool whole = true;
    for (int each = 0; each < window_; ++each) {
      const float near_level = profiles_.level(profile, static_cast<std::uint32_t>(cell - 1 - each));
      const float far_level = profiles_.level(profile, static_cast<std::uint32_t>(cell + each));
      whole &= near_level >= 0 && far_level >= 0;
      before += near_level;
      behind += far_level;
    }
    if (!whole) continue;
    const float step = (behind - before) / static_cast<float>(window_);
    steps_[std::size_t{profile} * profiles_.cells() + static_cast<std::size_t>(cell)] =
        (sign_ == EdgeSign::kBrightToDark ? -step : step);
    sizes_.push_back(std::abs(step));
  }
}

Sheet strongest_sheet(const VolumeProfiles& profiles, const EchoSteps& steps, float least_step) {
  std::vector<Sheet> sheets = strongest_sheets(profiles, steps, least_step, 1);
  return sheets.empty() ? Sheet() : std::move(sheets.front());
}

std::vector<Sheet> strongest_sheets(const VolumeProfiles& profiles, const EchoSteps& steps, float least_step,
                                    std::size_t most) {
  return Sheets(profiles, steps, least_step).strongest(most);
}

double contrast_of(const Sheet& sheet) {
  std::vector<float> steps;
  for (const SheetPoint& point : sheet) steps.push_back(point.step);
  return median(std::move(steps));
}

}  // namespace fanlight
