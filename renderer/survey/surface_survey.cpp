// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/surface_survey.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>

#include "renderer/survey/ray_start.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

namespace {

// A sheet may rise by so much from one profile to the next.
constexpr int kMostRiseCells = 3;
// The least step of a sheet, grey levels, is tried: with small steps sheets grow together, with large ones
// they fall apart.
constexpr float kLeastSteps[] = {8, 14, 20, 26, 32, 40, 50};
constexpr std::size_t kPeaks = 2;       // candidates in a profile: its largest steps
constexpr double kLeastCovered = 0.06;  // of the profiles
constexpr double kLeastOverClutter = 3;
constexpr int kFoundCells = 4;
constexpr double kRingDownMm = 15;
// From further aside the fan itself hides the sheet.
constexpr double kMostTiltDeg = 50;
// Tried for the detector, grey levels.
constexpr int kLeastThreshold = 10;
constexpr int kMostThreshold = 60;
constexpr int kThresholdStep = 2;

double median(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Steps of the echo along all profiles: mean of the cells behind minus mean of the cells before, or the
/// reverse for steps from bright to dark.
class Steps {
 public:
  Steps(const VolumeProfiles& profiles, const std::vector<int>& first_cells, EdgeSign sign)
      : profiles_(profiles),
        first_cells_(first_cells),
        sign_(sign == EdgeSign::kBrightToDark ? -1.0F : 1.0F),
        window_(std::max(1, static_cast<int>(std::lround(kSurveyWindowMm / profiles.cell_mm())))),
        steps_(std::size_t{profiles.profiles()} * profiles.cells(), 0.0F) {
    for (std::uint32_t profile = 0; profile < profiles.profiles(); ++profile) fill(profile);
  }

  float at(std::uint32_t profile, std::uint32_t cell) const {
    return steps_[std::size_t{profile} * profiles_.cells() + cell];
  }

  /// The first cell of a local maximum of at least `least` at or behind `from`; -1: none.
  int first_peak(std::uint32_t profile, int from, float least) const {
    const int cells = static_cast<int>(profiles_.cells());
    for (int cell = std::max({from, 1, first_cells_[profile]}); cell + 1 < cells; ++cell) {
      const auto here = static_cast<std::uint32_t>(cell);
      const float step = at(profile, here);
      if (step >= least && step >= at(profile, here - 1) && step > at(profile, here + 1)) return cell;
    }
    return -1;
  }

  /// Median size of all steps; 0 in a volume without noise.
  double clutter() const { return median(sizes_); }

 private:
  void fill(std::uint32_t profile) {
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
      steps_[std::size_t{profile} * profiles_.cells() + static_cast<std::size_t>(cell)] = sign_ * step;
      sizes_.push_back(std::abs(step));
    }
  }

  const VolumeProfiles& profiles_;
  const std::vector<int>& first_cells_;  // of each profile; what lies before is removed
  float sign_;
  int window_;
  std::vector<float> steps_;  // profiles x cells; 0 also where a window has no data
  std::vector<float> sizes_;  // of those with data
};

struct Peak {
  std::uint32_t profile = 0;
  int cell = 0;
  float step = 0;
};

/// The largest steps of each profile, and which of them hang together.
class Sheets {
 public:
  Sheets(const VolumeProfiles& profiles, const Steps& steps, float least_step) : least_step_(least_step) {
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

  /// The sheet with the largest sum of steps; of each profile its largest step.
  std::vector<Peak> strongest() {
    std::vector<double> sums(peaks_.size(), 0.0);
    for (std::size_t i = 0; i < peaks_.size(); ++i) sums[root(i)] += peaks_[i].step;
    if (sums.empty()) return {};
    const auto best = static_cast<std::size_t>(std::ranges::max_element(sums) - sums.begin());
    std::vector<Peak> sheet;
    for (std::size_t i = 0; i < peaks_.size(); ++i) {
      if (root(i) != best) continue;
      if (!sheet.empty() && sheet.back().profile == peaks_[i].profile) {
        if (peaks_[i].step > sheet.back().step) sheet.back() = peaks_[i];
      } else {
        sheet.push_back(peaks_[i]);
      }
    }
    return sheet;
  }

 private:
  void add_peaks(std::uint32_t profile, const Steps& steps) {
    std::vector<Peak> found;
    for (int cell = steps.first_peak(profile, 0, least_step_); cell >= 0;
         cell = steps.first_peak(profile, cell + 1, least_step_)) {
      found.push_back({profile, cell, steps.at(profile, static_cast<std::uint32_t>(cell))});
    }
    if (found.size() > kPeaks) {
      std::ranges::nth_element(found, found.begin() + kPeaks, std::greater(), &Peak::step);
      found.resize(kPeaks);
      std::ranges::sort(found, {}, &Peak::cell);
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
  std::vector<Peak> peaks_;            // in order of profiles, then of cells
  std::vector<std::size_t> first_of_;  // index of each profile's first peak, and the end
  std::vector<std::size_t> parents_;   // union-find
};

/// How a sheet lies in space.
struct Attitude {
  glm::dvec3 normal{0, -1, 0};  // its mean, towards the probe
  double flatness = 0;          // length of the mean of the normals, by area: 1 for a plane
};

/// Of the triangles between neighbouring profiles.
Attitude attitude_of(const VolumeProfiles& profiles, const std::vector<Peak>& sheet) {
  std::vector<int> cells(profiles.profiles(), -1);
  for (const Peak& peak : sheet) cells[peak.profile] = peak.cell;
  glm::dvec3 sum(0);
  double area = 0;
  for (const Peak& peak : sheet) {
    const std::uint32_t right = peak.profile + 1;
    const std::uint32_t next = peak.profile + profiles.across();
    if (right % profiles.across() == 0 || next >= profiles.profiles() || cells[right] < 0 || cells[next] < 0)
      continue;
    const glm::dvec3 here = profiles.position(peak.profile, peak.cell);
    glm::dvec3 normal = glm::cross(profiles.position(right, cells[right]) - here,
                                   profiles.position(next, cells[next]) - here);
    const glm::dvec3 beam = profiles.position(peak.profile, peak.cell + 1) - here;
    if (glm::dot(normal, beam) > 0) normal = -normal;
    sum += normal;
    area += glm::length(normal);
  }
  const double length = glm::length(sum);
  return length > 0 ? Attitude{sum / length, length / area} : Attitude{};
}

/// The ranges of the profiles in which a step of `threshold` is near the sheet.
std::vector<StartRange> start_ranges(const VolumeProfiles& profiles, const Steps& steps,
                                     const std::vector<Peak>& sheet, const glm::dvec3& normal,
                                     float threshold) {
  std::vector<StartRange> ranges;
  for (const Peak& peak : sheet) {
    const auto depth_mm = [&](int cell) { return -glm::dot(normal, profiles.position(peak.profile, cell)); };
    int before = -1;
    int cell = steps.first_peak(peak.profile, 0, threshold);
    while (cell >= 0 && cell < peak.cell - kFoundCells) {
      before = cell;
      cell = steps.first_peak(peak.profile, cell + 1, threshold);
    }
    if (cell < 0 || cell > peak.cell + kFoundCells) continue;
    const StartRange range{before < 0 ? -HUGE_VAL : depth_mm(before), depth_mm(cell)};
    // Along a beam at a right angle to the view, or beyond, nothing is found first.
    if (range.from_mm < range.to_mm) ranges.push_back(range);
  }
  return ranges;
}

/// The threshold and the start of the rays by which a search finds the sheet first in the most profiles.
void choose_search(const VolumeProfiles& profiles, const Steps& steps, const std::vector<Peak>& sheet,
                   SurfaceSurvey& survey) {
  std::array<Start, (kMostThreshold - kLeastThreshold) / kThresholdStep + 1> starts{};
  const auto threshold_at = [](std::ptrdiff_t index) {
    return kLeastThreshold + static_cast<double>(index) * kThresholdStep;
  };
  std::size_t most = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    starts[i] = best_start(start_ranges(profiles, steps, sheet, -survey.view,
                                        static_cast<float>(threshold_at(static_cast<std::ptrdiff_t>(i)))));
    most = std::max(most, starts[i].found);
  }
  const auto as_good = [&](const Start& start) {
    return static_cast<double>(start.found) >= 0.99 * static_cast<double>(most);
  };
  const auto lowest = std::ranges::find_if(starts, as_good) - starts.begin();
  const auto highest = std::find_if(starts.rbegin(), starts.rend(), as_good).base() - starts.begin() - 1;
  // In the middle: a low one finds clutter elsewhere, and a high one loses the sheet's slanted parts.
  survey.threshold = std::round(std::sqrt(threshold_at(lowest) * threshold_at(highest)));
  const auto chosen = static_cast<std::size_t>((survey.threshold - kLeastThreshold) / kThresholdStep);
  survey.start_mm = starts[chosen].depth_mm;
  survey.found_share = static_cast<double>(starts[chosen].found) / static_cast<double>(sheet.size());
}

/// The direction of the view: against the normal, but not from too far aside.
void look_along(SurfaceSurvey& survey) {
  // view_frame(): forward = (-sin yaw cos pitch, cos yaw cos pitch, -sin pitch).
  const glm::dvec3 forward = -survey.normal;
  const auto limited = [](double angle_rad) {
    return std::round(std::clamp(degrees(angle_rad), -kMostTiltDeg, kMostTiltDeg));
  };
  survey.yaw_deg = limited(std::atan2(-forward.x, forward.y));
  survey.pitch_deg = limited(std::asin(std::clamp(-forward.z, -1.0, 1.0)));
  const double yaw = radians(survey.yaw_deg);
  const double pitch = radians(survey.pitch_deg);
  survey.view = {-std::sin(yaw) * std::cos(pitch), std::cos(yaw) * std::cos(pitch), -std::sin(pitch)};
}

/// Of the sheet, along the profiles, from the first cell.
double median_depth_mm(const VolumeProfiles& profiles, const std::vector<Peak>& sheet) {
  std::vector<float> depths_mm;
  depths_mm.reserve(sheet.size());
  for (const Peak& peak : sheet) depths_mm.push_back(static_cast<float>(peak.cell * profiles.cell_mm()));
  return median(std::move(depths_mm));
}

SurfaceSurvey survey_of(const VolumeProfiles& profiles, const std::vector<Peak>& sheet) {
  SurfaceSurvey survey;
  survey.covered_share = static_cast<double>(sheet.size()) / profiles.profiles();
  std::vector<float> contrasts;
  for (const Peak& peak : sheet) {
    contrasts.push_back(peak.step);
    survey.points.push_back(profiles.position(peak.profile, peak.cell));
    survey.centre += survey.points.back() / static_cast<double>(sheet.size());
  }
  survey.contrast = median(contrasts);
  const Attitude attitude = attitude_of(profiles, sheet);
  survey.normal = attitude.normal;
  survey.flatness = attitude.flatness;
  look_along(survey);
  return survey;
}

/// A large sheet of high contrast that is found first and can be seen from one side. The root: a clean sheet
/// is better than twice as much that has grown together with its neighbours.
double merit(const SurfaceSurvey& survey) {
  const double clean = survey.found_share * survey.flatness;
  return std::sqrt(survey.covered_share) * survey.contrast * clean * clean;
}

std::optional<SurfaceSurvey> find_steps(const VolumeProfiles& profiles, const std::vector<int>& first_cells,
                                        EdgeSign sign, const std::stop_token& stop) {
  const Steps steps(profiles, first_cells, sign);
  const double clutter = steps.clutter();
  std::optional<SurfaceSurvey> best;
  for (const float least_step : kLeastSteps) {
    if (stop.stop_requested()) return std::nullopt;
    const std::vector<Peak> sheet = Sheets(profiles, steps, least_step).strongest();
    if (sheet.empty()) continue;
    SurfaceSurvey survey = survey_of(profiles, sheet);
    survey.clutter = clutter;
    survey.sign = sign;
    if (survey.covered_share < kLeastCovered || survey.contrast < kLeastOverClutter * clutter) continue;
    // The echo of the probe's own face fades into the dark: that is no fluid behind tissue.
    if (sign == EdgeSign::kBrightToDark && median_depth_mm(profiles, sheet) < kRingDownMm) continue;
    choose_search(profiles, steps, sheet, survey);
    if (!best || merit(survey) > merit(*best)) best = std::move(survey);
  }
  return best;
}

}  // namespace

std::optional<SurfaceSurvey> find_surface(const Volume& volume, const std::stop_token& stop,
                                          const std::optional<NearTissue>& removed) {
  const VolumeProfiles profiles(volume, stop);
  if (stop.stop_requested()) return std::nullopt;
  std::vector<int> first_cells(profiles.profiles());
  for (std::uint32_t profile = 0; removed && profile < profiles.profiles(); ++profile)
    first_cells[profile] = static_cast<int>(std::ceil(profiles.end_cell(profile, *removed)));
  // Behind most surfaces of interest, such as skin in fluid, the echo is brighter.
  if (auto found = find_steps(profiles, first_cells, EdgeSign::kDarkToBright, stop)) return found;
  return find_steps(profiles, first_cells, EdgeSign::kBrightToDark, stop);
}

}  // namespace fanlight
