// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/shell_survey.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "renderer/survey/echo_sheets.hpp"
#include "renderer/survey/profile_map.hpp"

namespace fanlight {

namespace {

// Tried from the cleanest on: with small steps walls grow together with their neighbours.
constexpr float kWallSteps[] = {50, 32, 20};
constexpr double kLeastOfShell = 0.06;  // of the profiles, by each wall
constexpr double kLeastWallOverClutter = 3;
// The far wall lies so much behind the near one.
constexpr double kLeastInsideMm = 15;
constexpr double kLeastRadiusMm = 12;
constexpr double kMostRadiusMm = 75;
// A sphere through one wall alone is less sure.
constexpr double kMostBentMm = 150;
// A skull is an ellipsoid, and parts of the neighbourhood hang together with it: of the radius.
constexpr double kMostOff = 0.3;
constexpr double kLeastOnSphere = 0.75;  // of each wall's points
// From the inner side of the wall back to before its outer one, a bone of 2 to 4 mm blurred by the pulse.
constexpr double kWallMm = 5;
constexpr double kHeldMm = 1.5;
constexpr int kShellSmoothings = 6;
// The far wall is a bright line: behind it the echo falls to less than this share of its height. Measured:
// 0.33 and 0.35 in two fetal heads. Behind a bladder or a sac it stays bright.
constexpr double kMostBehindLine = 0.6;
// A wall spans more profiles than this in each direction.
constexpr std::uint32_t kLeastSpan = 3;

struct Sphere {
  glm::dvec3 centre{};
  double radius_mm = 0;
  double off(const glm::dvec3& point) const {
    return std::abs(glm::distance(point, centre) - radius_mm) / radius_mm;
  }
};

/// Least squares of |p|^2 = 2 c p + (r^2 - |c|^2), which is linear in its unknowns (Kasa), in units of their
/// spread about their mean. nullopt: they lie in a plane.
std::optional<Sphere> sphere_through(const std::vector<glm::dvec3>& points) {
  if (points.empty()) return std::nullopt;
  const auto count = static_cast<double>(points.size());
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& point : points) mean += point / count;
  double spread = 0;
  for (const glm::dvec3& point : points) spread += glm::dot(point - mean, point - mean) / count;
  if (!(spread > 0)) return std::nullopt;
  const double unit_mm = std::sqrt(spread);
  glm::dmat4 matrix(0.0);
  glm::dvec4 right(0.0);
  for (const glm::dvec3& point : points) {
    const glm::dvec3 at = (point - mean) / unit_mm;
    const glm::dvec4 row(2.0 * at, 1);
    matrix += glm::outerProduct(row, row) / count;
    right += glm::dot(at, at) / count * row;
  }
  constexpr double kFlat = 1e-6;
  if (std::abs(glm::determinant(matrix)) < kFlat) return std::nullopt;
  const glm::dvec4 solved = glm::inverse(matrix) * right;
  const glm::dvec3 centre(solved);
  const double square = solved.w + glm::dot(centre, centre);
  if (!(square > 0)) return std::nullopt;
  return Sphere{mean + unit_mm * centre, unit_mm * std::sqrt(square)};
}

class Shell {
 public:
  Shell(const VolumeProfiles& profiles, Sheet near_wall, Sheet far_wall)
      : profiles_(profiles), near_(std::move(near_wall)), far_(std::move(far_wall)) {}

  /// Fits the sphere, leaves out what lies off it, and fits it again. False: they are no shell.
  bool fit() {
    const std::size_t near_points = near_.size();
    const std::size_t far_points = far_.size();
    for (int round = 0; round < 2; ++round) {
      std::vector<glm::dvec3> points;
      for (const Sheet* wall : {&near_, &far_})
        for (const SheetPoint& point : *wall) points.push_back(profiles_.position(point.profile, point.cell));
      const auto sphere = sphere_through(points);
      if (!sphere || sphere->radius_mm < kLeastRadiusMm || sphere->radius_mm > kMostRadiusMm) return false;
      sphere_ = *sphere;
      leave_out(near_, -1);
      leave_out(far_, 1);
    }
    const auto kept = [](const Sheet& wall, std::size_t points) {
      return static_cast<double>(wall.size()) >= kLeastOnSphere * static_cast<double>(points);
    };
    return kept(near_, near_points) && kept(far_, far_points);
  }

  const Sheet& near_wall() const { return near_; }
  double radius_mm() const { return sphere_.radius_mm; }

  std::optional<NearTissue> before(const Volume& volume) const {
    ProfileMap map(profiles_);
    std::vector<double> cells(profiles_.profiles(), -1);
    for (const SheetPoint& point : near_) {
      cells[point.profile] = std::max(0.0, point.cell - kWallMm / profiles_.cell_mm());
      map.set(point.profile, cells[point.profile]);
    }
    map.fill();
    const double held = kHeldMm / profiles_.cell_mm();
    map.smooth(kShellSmoothings, [&](std::uint32_t profile, double cell) {
      const double known = cells[profile];
      return known < 0 ? cell : std::clamp(cell, known - held, known + held);
    });
    return map.near_tissue(volume);
  }

 private:
  /// Points that lie off the sphere, or on its other side. `side`: -1 for the one towards the probe.
  void leave_out(Sheet& wall, double side) const {
    std::erase_if(wall, [&](const SheetPoint& point) {
      const glm::dvec3 here = profiles_.position(point.profile, point.cell);
      const glm::dvec3 beam = profiles_.position(point.profile, point.cell + 1.0) - here;
      return side * glm::dot(here - sphere_.centre, beam) < 0 || sphere_.off(here) > kMostOff;
    });
  }

  const VolumeProfiles& profiles_;
  Sheet near_;
  Sheet far_;
  Sphere sphere_;
};

/// Profiles across and frames, from the first point to the last.
bool spans_both_ways(const VolumeProfiles& profiles, const Sheet& sheet) {
  const auto [first, last] = std::ranges::minmax(
      sheet, {}, [&](const SheetPoint& point) { return point.profile % profiles.across(); });
  const std::uint32_t across = last.profile % profiles.across() - first.profile % profiles.across();
  const std::uint32_t along =
      sheet.back().profile / profiles.across() - sheet.front().profile / profiles.across();
  return across > kLeastSpan && along > kLeastSpan;
}

bool stands_out(const VolumeProfiles& profiles, const Sheet& sheet, double clutter) {
  return !sheet.empty() && spans_both_ways(profiles, sheet) &&
         static_cast<double>(sheet.size()) >= kLeastOfShell * profiles.profiles() &&
         contrast_of(sheet) >= kLeastWallOverClutter * clutter;
}

/// Whether a wall by itself bends about a point on its one side. `side`: -1 for a wall that bulges towards
/// the probe, 1 for one that is hollow. The tissue next to a curved array is neither: it bends about the
/// array.
bool bends(const VolumeProfiles& profiles, const Sheet& wall, double side) {
  std::vector<glm::dvec3> points;
  for (const SheetPoint& point : wall) points.push_back(profiles.position(point.profile, point.cell));
  const auto sphere = sphere_through(points);
  if (!sphere || sphere->radius_mm > kMostBentMm) return false;
  const auto is_on_side = [&](const SheetPoint& point) {
    const glm::dvec3 here = profiles.position(point.profile, point.cell);
    const glm::dvec3 beam = profiles.position(point.profile, point.cell + 1.0) - here;
    return side * glm::dot(here - sphere->centre, beam) > 0;
  };
  return static_cast<double>(std::ranges::count_if(wall, is_on_side)) >=
         kLeastOnSphere * static_cast<double>(wall.size());
}

/// Whether the echo of a wall falls again behind it, in the median of its points.
bool is_line(const VolumeProfiles& profiles, const Sheet& wall) {
  const auto cells = [&](double length_mm) { return static_cast<int>(length_mm / profiles.cell_mm()); };
  const auto level = [&](const SheetPoint& point, int away) {
    const int cell = point.cell + away;
    const bool inside = cell >= 0 && cell < static_cast<int>(profiles.cells());
    return inside ? profiles.level(point.profile, static_cast<std::uint32_t>(cell)) : VolumeProfiles::kNoData;
  };
  std::vector<float> shares;
  for (const SheetPoint& point : wall) {
    float peak = 0;
    for (int away = 0; away <= cells(4); ++away) peak = std::max(peak, level(point, away));
    const float before = level(point, -cells(4));
    const float behind = level(point, cells(8));
    if (before >= 0 && behind >= 0 && peak > before) shares.push_back((behind - before) / (peak - before));
  }
  if (shares.empty()) return false;
  const auto middle = shares.begin() + static_cast<std::ptrdiff_t>(shares.size() / 2);
  std::ranges::nth_element(shares, middle);
  return *middle <= kMostBehindLine;
}

/// What lies before a wall, by a distance, and behind near tissue.
std::vector<CellRange> before_wall(const VolumeProfiles& profiles, const Sheet& wall,
                                   const std::optional<NearTissue>& near) {
  std::vector<CellRange> ranges = all_cells(profiles);
  for (std::uint32_t profile = 0; near && profile < profiles.profiles(); ++profile)
    ranges[profile].first = static_cast<int>(std::ceil(profiles.end_cell(profile, *near)));
  const int inside = static_cast<int>(kLeastInsideMm / profiles.cell_mm());
  for (const SheetPoint& point : wall) ranges[point.profile].end = std::max(0, point.cell - inside);
  return ranges;
}

}  // namespace

std::optional<ShellSurvey> find_shell(const Volume& volume, const std::stop_token& stop) {
  const VolumeProfiles profiles(volume, stop);
  if (stop.stop_requested()) return std::nullopt;
  if (profiles.across() < 2 || profiles.frames() < 2 || profiles.cells() == 0) return std::nullopt;
  const EchoSteps brighter(profiles, all_cells(profiles), EdgeSign::kDarkToBright);
  const double clutter = brighter.clutter();
  for (const float far_step : kWallSteps) {
    const Sheet far_wall = strongest_sheet(profiles, brighter, far_step);
    if (!stands_out(profiles, far_wall, clutter) || !bends(profiles, far_wall, 1) ||
        !is_line(profiles, far_wall))
      continue;
    const EchoSteps darker(profiles, before_wall(profiles, far_wall, {}), EdgeSign::kBrightToDark);
    for (const float near_step : kWallSteps) {
      if (stop.stop_requested()) return std::nullopt;
      const Sheet near_wall = strongest_sheet(profiles, darker, near_step);
      if (!stands_out(profiles, near_wall, clutter) || !bends(profiles, near_wall, -1)) continue;
      Shell shell(profiles, near_wall, far_wall);
      if (!shell.fit()) continue;
      const auto before = shell.before(volume);
      if (!before) return std::nullopt;
      const EchoSteps shown(profiles, before_wall(profiles, far_wall, before), EdgeSign::kBrightToDark);
      return ShellSurvey{.near_wall = survey_of(profiles, shown, shell.near_wall()),
                         .before = *before,
                         .radius_mm = shell.radius_mm()};
    }
  }
  return std::nullopt;
}

}  // namespace fanlight
