// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/surface_survey.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "renderer/survey/echo_sheets.hpp"
#include "renderer/survey/ray_start.hpp"
#include "renderer/survey/sheet_borders.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

namespace {

// Least steps of a sheet that are tried, grey levels.
constexpr float kLeastSteps[] = {8, 14, 20, 26, 32, 40, 50};
constexpr std::size_t kMostSheets = 4;  // of each least step
constexpr double kLeastCovered = 0.06;  // of the profiles
// What makes a sheet that of a body.
// Of the way from fluid to tissue, what is fluid at most, and a step to tissue at least.
constexpr double kMostFluid = 0.3;
constexpr double kLeastStepOfBody = 0.4;
// Deviations of the speckle: 17 dB. A lump in tissue has less.
constexpr double kLeastStepOverSpeckle = 3;
// Of its border, the share before other sheets, less that behind them. Bodies have 0.17 to 0.7: less where
// limbs lie before them. What is no body and passes all other limits has 0.04 at most.
constexpr double kLeastBefore = 0.12;
// Of its border, where the fan ends. Bodies have up to 0.2; a ledge or a membrane over half of the fan, 0.6.
constexpr double kMostAtFan = 0.4;
// Its border within the fan, of that of a square of its area. Bodies have 0.9 to 1.45; layers with gaps, 1.8.
constexpr double kMostBorder = 1.6;
// Of profiles in each direction: fewer show no border.
constexpr std::uint32_t kLeastAcross = 8;
constexpr double kLeastOverClutter = 3;
constexpr int kFoundCells = 4;
constexpr double kRingDownMm = 15;
// From further aside the fan itself hides the sheet.
constexpr double kMostTiltDeg = 50;
// Tried for the detector, grey levels.
constexpr int kLeastThreshold = 10;
constexpr int kMostThreshold = 60;
constexpr int kThresholdStep = 2;

/// How a sheet lies in space.
struct Attitude {
  glm::dvec3 normal{0, -1, 0};  // its mean, towards the probe
  double flatness = 0;          // length of the mean of the normals, by area: 1 for a plane
};

/// Of the triangles between neighbouring profiles.
Attitude attitude_of(const VolumeProfiles& profiles, const Sheet& sheet) {
  std::vector<int> cells(profiles.profiles(), -1);
  for (const SheetPoint& point : sheet) cells[point.profile] = point.cell;
  glm::dvec3 sum(0);
  double area = 0;
  for (const SheetPoint& point : sheet) {
    const std::uint32_t right = point.profile + 1;
    const std::uint32_t next = point.profile + profiles.across();
    if (right % profiles.across() == 0 || next >= profiles.profiles() || cells[right] < 0 || cells[next] < 0)
      continue;
    const glm::dvec3 here = profiles.position(point.profile, point.cell);
    glm::dvec3 normal = glm::cross(profiles.position(right, cells[right]) - here,
                                   profiles.position(next, cells[next]) - here);
    const glm::dvec3 beam = profiles.position(point.profile, point.cell + 1) - here;
    if (glm::dot(normal, beam) > 0) normal = -normal;
    sum += normal;
    area += glm::length(normal);
  }
  const double length = glm::length(sum);
  return length > 0 ? Attitude{sum / length, length / area} : Attitude{};
}

/// The ranges of the profiles in which a step of `threshold` is near the sheet.
std::vector<StartRange> start_ranges(const VolumeProfiles& profiles, const EchoSteps& steps,
                                     const Sheet& sheet, const glm::dvec3& normal, float threshold) {
  std::vector<StartRange> ranges;
  for (const SheetPoint& point : sheet) {
    const auto depth_mm = [&](int cell) { return -glm::dot(normal, profiles.position(point.profile, cell)); };
    int before = -1;
    int cell = steps.first_peak(point.profile, 0, threshold);
    while (cell >= 0 && cell < point.cell - kFoundCells) {
      before = cell;
      cell = steps.first_peak(point.profile, cell + 1, threshold);
    }
    if (cell < 0 || cell > point.cell + kFoundCells) continue;
    const StartRange range{before < 0 ? -HUGE_VAL : depth_mm(before), depth_mm(cell)};
    // Along a beam at a right angle to the view, or beyond, nothing is found first.
    if (range.from_mm < range.to_mm) ranges.push_back(range);
  }
  return ranges;
}

/// The threshold and the start of the rays by which a search finds the sheet first in the most profiles.
void choose_search(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet,
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
double median_depth_mm(const VolumeProfiles& profiles, const Sheet& sheet) {
  std::vector<int> cells;
  for (const SheetPoint& point : sheet) cells.push_back(point.cell);
  const auto middle = cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / 2);
  std::ranges::nth_element(cells, middle);
  return *middle * profiles.cell_mm();
}

/// The borders of a sheet that is a body's in fluid, such as a fetus before the wall of the uterus. nullopt:
/// it is none.
std::optional<SheetBorders> body_borders(const VolumeProfiles& profiles, const EchoSteps& steps,
                                         const Sheet& sheet, const EchoLevels& levels) {
  if (steps.sign() != EdgeSign::kDarkToBright || !levels.known) return std::nullopt;
  if (profiles.across() < kLeastAcross || profiles.frames() < kLeastAcross) return std::nullopt;
  const double contrast = contrast_of(sheet);
  if (contrast < kLeastStepOfBody * (levels.tissue - levels.fluid)) return std::nullopt;
  if (levels.in_decibels() && contrast < kLeastStepOverSpeckle * levels.noise) return std::nullopt;
  const SheetBorders borders = sheet_borders(profiles, steps, sheet,
                                             {.least_step = static_cast<float>(contrast / 2),
                                              .fluid = std::lerp(levels.fluid, levels.tissue, kMostFluid)});
  const bool is_body = borders.before_mm - borders.behind_mm > kLeastBefore * borders.all_mm &&
                       borders.fan_mm < kMostAtFan * borders.all_mm &&
                       borders.all_mm - borders.fan_mm < kMostBorder * 4 * std::sqrt(borders.area_mm2);
  return is_body ? std::optional(borders) : std::nullopt;
}

double merit(const SurfaceSurvey& survey) {
  return clarity(survey) * survey.contrast;
}

std::optional<SurfaceSurvey> find_steps(const VolumeProfiles& profiles, const EchoLevels& levels,
                                        const std::vector<CellRange>& ranges, EdgeSign sign,
                                        const std::stop_token& stop) {
  const EchoSteps steps(profiles, ranges, sign);
  const double least_contrast = kLeastOverClutter * steps.clutter();
  std::optional<SurfaceSurvey> body;
  std::optional<SurfaceSurvey> other;
  for (const float least_step : kLeastSteps) {
    for (const Sheet& sheet : strongest_sheets(profiles, steps, least_step, kMostSheets)) {
      if (stop.stop_requested()) return std::nullopt;
      if (static_cast<double>(sheet.size()) < kLeastCovered * profiles.profiles()) continue;
      if (sheet.empty() || contrast_of(sheet) < least_contrast) continue;
      // The echo of the probe's own face fades into the dark: that is no fluid behind tissue.
      if (sign == EdgeSign::kBrightToDark && median_depth_mm(profiles, sheet) < kRingDownMm) continue;
      SurfaceSurvey survey = survey_of(profiles, steps, sheet);
      if (const auto borders = body_borders(profiles, steps, sheet, levels)) {
        survey.is_body = true;
        survey.at_fan_share = borders->fan_mm / borders->all_mm;
      }
      std::optional<SurfaceSurvey>& best = survey.is_body ? body : other;
      if (!best || merit(survey) > merit(*best)) best = std::move(survey);
    }
  }
  if (!body) return other;
  if (other) body->behind = std::move(other->points);
  return body;
}

}  // namespace

double clarity(const SurfaceSurvey& survey) {
  // The root: a clean sheet is better than twice as much that has grown together with its neighbours.
  const double clean = survey.found_share * survey.flatness;
  return std::sqrt(survey.covered_share) * clean * clean;
}

SurfaceSurvey survey_of(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet) {
  SurfaceSurvey survey;
  survey.sign = steps.sign();
  survey.covered_share = static_cast<double>(sheet.size()) / profiles.profiles();
  for (const SheetPoint& point : sheet) {
    survey.points.push_back(profiles.position(point.profile, point.cell));
    survey.centre += survey.points.back() / static_cast<double>(sheet.size());
  }
  survey.contrast = contrast_of(sheet);
  survey.clutter = steps.clutter();
  const Attitude attitude = attitude_of(profiles, sheet);
  survey.normal = attitude.normal;
  survey.flatness = attitude.flatness;
  look_along(survey);
  choose_search(profiles, steps, sheet, survey);
  return survey;
}

std::optional<SurfaceSurvey> find_surface(const Volume& volume, const EchoLevels& levels,
                                          const std::stop_token& stop,
                                          const std::optional<NearTissue>& removed) {
  const VolumeProfiles profiles(volume, stop);
  if (stop.stop_requested()) return std::nullopt;
  std::vector<CellRange> ranges = all_cells(profiles);
  for (std::uint32_t profile = 0; removed && profile < profiles.profiles(); ++profile)
    ranges[profile].first = static_cast<int>(std::ceil(profiles.end_cell(profile, *removed)));
  // Behind most surfaces of interest, such as skin in fluid, the echo is brighter.
  if (auto found = find_steps(profiles, levels, ranges, EdgeSign::kDarkToBright, stop)) return found;
  return find_steps(profiles, levels, ranges, EdgeSign::kBrightToDark, stop);
}

}  // namespace fanlight
